#include "engine/particles/sort.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>

#include "engine/core/random.h"
#include "tests/support/threads.h"

using namespace whorl;

TEST_CASE("each step along the curve goes to an adjacent cell", "[particles]") {
    // 8^3 cells with one particle each fill the curve: Hilbert's order never jumps.
    std::vector<Vec3> x;
    for (int k = 0; k < 512; ++k) x.push_back(Vec3(Real(k % 8), Real(k / 8 % 8), Real(k / 64)) * Real(0.2) + Vec3::Constant(Real(0.1)));
    const auto order = curve_order(x, Real(0.2));
    REQUIRE(order.size() == x.size());
    for (std::size_t k = 1; k < order.size(); ++k) REQUIRE((x[order[k]] - x[order[k - 1]]).norm() == Approx(0.2).epsilon(1e-4));
}

TEST_CASE("particles of one cell keep their order, and non-finite particles come last", "[particles]") {
    const Real nan = std::numeric_limits<Real>::quiet_NaN(), far = std::numeric_limits<Real>::max() / 8;
    std::vector<Vec3> x{{nan, 0, 0}, {Real(0.5), 0, 0},  {Real(0.1), 0, 0},   {Real(0.2), 0, 0},
                        {0, far, 0}, {Real(0.51), 0, 0}, {0, 0, -1 / Real(0)}};
    const auto order = curve_order(x, Real(0.4));
    const auto place = [&](Index i) { return std::find(order.begin(), order.end(), i) - order.begin(); };
    CHECK(place(0) == 5);
    CHECK(place(6) == 6);
    CHECK(place(2) + 1 == place(3));
    CHECK(place(1) + 1 == place(5));
    CHECK(curve_order({}, 1).empty());
}

TEST_CASE("the order is equal for 1, 2 and 4 threads, and a sorted store stays unchanged", "[particles]") {
    std::vector<Vec3> x;
    RandomNumbers random(1);
    for (int k = 0; k < 4000; ++k) x.push_back({Real(random()), Real(random()), Real(random())});
    CHECK(test::same_on_threads([&] { return curve_order(x, Real(0.07)); }));
    std::vector<Vec3> sorted;
    for (Index i : curve_order(x, Real(0.07))) sorted.push_back(x[i]);
    const auto again = curve_order(sorted, Real(0.07));
    for (std::size_t k = 0; k < again.size(); ++k) REQUIRE(again[k] == static_cast<Index>(k));
}
