#include "tests/support/viscous_block.h"

#include <cmath>

namespace whorl::test {

Vec3 noise(Index i) { return Vec3(std::sin(Real(3 * i)), std::sin(Real(5 * i)), std::sin(Real(7 * i))); }

TestWorld uneven_block(double mu, Real unevenness, std::vector<Stage> stages, const Vec3& half) {
    TestWorld w(0.1, 2, Domain{Vec3(-2, -2, -2), Vec3(2, 2, 2), {}});
    w.use(std::move(stages));
    w.place(-half, half, mu);
    auto x = w.column<field::position>();
    auto viscosity = w.column<field::viscosity>();
    for (std::size_t i = 0; i < x.size(); ++i) {
        x[i] += unevenness * Real(0.1) * noise(static_cast<Index>(i));
        viscosity[i] *= 1 + Real(i % 7);
    }
    return w;
}

double inner(Span<const Vec3> a, Span<const Vec3> b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += a[i].cast<double>().dot(b[i].cast<double>());
    return sum;
}

}  // namespace whorl::test
