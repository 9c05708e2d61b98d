#pragma once
/// Checks of preconditioners that approximate the inverse of a symmetric positive definite matrix.
#include <catch2/catch.hpp>
#include <cmath>

#include "engine/math/conjugate_gradients.h"

namespace whorl::test {

/// Checks r.M r > 0, s.M s > 0, and r.M s = s.M r within `tolerance` sqrt(r.M r s.M s). @return M r
template <class Preconditioner>
Column<Real> check_symmetric_and_positive(const Preconditioner& M, const Column<Real>& r, const Column<Real>& s, double tolerance) {
    Column<Real> Mr(r.size()), Ms(s.size());
    M(r, Mr), M(s, Ms);
    const double rMr = dot<Real>(r, Mr), sMs = dot<Real>(s, Ms);
    CHECK(rMr > 0);
    CHECK(sMs > 0);
    CHECK(std::abs(dot<Real>(r, Ms) - dot<Real>(s, Mr)) < tolerance * std::sqrt(rMr * sMs));
    return Mr;
}

/// Iterations in which conjugate gradients solve A x = b from zero. @param A with multiply(in, out)
template <class Matrix, class Preconditioner>
int iterations(const Matrix& A, const Preconditioner& M, const Column<Real>& b, double tolerance) {
    Column<Real> x(b.size(), 0);
    const SolveReport report = conjugate_gradients<Real>([&](Span<const Real> in, Span<Real> out) { A.multiply(in, out); }, M,
                                                         Span<const Real>(b), Span<Real>(x), {tolerance, 500});
    CHECK(report.converged);
    return report.iterations;
}

}  // namespace whorl::test
