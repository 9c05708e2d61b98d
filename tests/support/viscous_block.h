#pragma once
/// Bodies of fluid for tests of the viscous operators.
#include "tests/support/world.h"

namespace whorl::test {

/// Three numbers that look random, the same in every run.
Vec3 noise(Index i);

/// A free box of fluid with the spacing 0.1 m, its particles `unevenness` spacings off the lattice, with viscosity from 1 to 7 times mu.
TestWorld uneven_block(double mu, Real unevenness, std::vector<Stage> stages = {},
                       const Vec3& half = Vec3(Real(0.4), Real(0.3), Real(0.3)));

double inner(Span<const Vec3> a, Span<const Vec3> b);

/// |u.A v - v.A u| over |A u| |v|, for two noisy u and v.
template <class Operator>
double asymmetry(const Operator& A) {
    const auto n = static_cast<std::size_t>(A.size());
    std::vector<Vec3> u(n), v(n), Au(n), Av(n);
    for (std::size_t i = 0; i < n; ++i) u[i] = noise(static_cast<Index>(2 * i + 1)), v[i] = noise(static_cast<Index>(11 * i + 4));
    A.multiply(u, Au);
    A.multiply(v, Av);
    return std::abs(inner(Au, v) - inner(Av, u)) / std::sqrt(inner(Au, Au) * inner(v, v));
}

}  // namespace whorl::test
