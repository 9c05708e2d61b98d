#include "engine/particles/sample.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

using namespace whorl;

TEST_CASE("a sweep of relaxation moves even crowded points by at most a fifth of a spacing", "[particles]") {
    const auto in_ball = [](const Vec3& p) { return p.norm() - 10; };
    std::vector<Vec3> x;
    for (int k = 0; k < 40; ++k) x.push_back(Real(0.1) * Vec3(std::sin(Real(k)), std::sin(Real(3 * k)), std::cos(Real(7 * k))));
    std::vector<Vec3> moved = x;
    relax(moved, in_ball, 1, Domain{}, 1);
    Real farthest = 0;
    for (std::size_t k = 0; k < x.size(); ++k) farthest = std::max(farthest, (moved[k] - x[k]).norm());
    CHECK(farthest == Approx(0.2).epsilon(1e-4));
}
