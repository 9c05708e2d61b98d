#include "engine/theory/falling_thread.h"

#include <catch2/catch.hpp>
#include <cmath>

using namespace whorl;

TEST_CASE("a falling thread of great viscosity creeps, one of little viscosity falls freely", "[theory]") {
    // Creep that hardly thins: u(H) = U + g H^2/(6 nu).
    const FallingThread stiff({1, 0.1, 9.81, 50});
    CHECK(stiff.end_speed() - 1 == Approx(9.81 * 0.01 / 300).epsilon(1e-3));
    CHECK(stiff.speed(0) == Approx(1).epsilon(1e-9));
    const FallingThread thin({1, 1, 9.81, 1e-3});
    CHECK(thin.end_speed() == Approx(std::sqrt(1 + 2 * 9.81)).epsilon(0.01));
    CHECK(thin.speed(0.5) == Approx(std::sqrt(1 + 9.81)).epsilon(0.01));
    const double slice = thin.mean_speed(0.2, 0.1);
    CHECK(slice > thin.speed(0.2));
    CHECK(slice < thin.speed(0.3));
}

TEST_CASE("the end speed of estimates is that of the thread in both limits, and not 20 % off between them", "[theory]") {
    for (const double viscosity : {1e-3, 0.05, 0.2, 1.0, 5.0}) {
        const FallingThreadParameters p{0.1, 0.25, 9.81, viscosity};
        INFO(viscosity);
        CHECK(fast_end_speed(p) == Approx(FallingThread(p).end_speed()).epsilon(0.2));
    }
    CHECK(fast_end_speed({0.1, 0.25, 9.81, 0}) == Approx(std::sqrt(0.01 + 2 * 9.81 * 0.25)));
    CHECK(fast_end_speed({0.1, 0.25, 9.81, 50}) == Approx(FallingThread({0.1, 0.25, 9.81, 50}).end_speed()).epsilon(0.02));
}
