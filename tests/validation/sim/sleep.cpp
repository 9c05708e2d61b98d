/// Sleep changes nothing that matters: heights, densities, the number of particles.
#include <utility>

#include "tests/support/puddle.h"

using namespace whorl;
using test::Pool;
using test::puddle;

namespace sleep_validation {

namespace {

/// @param rest what counts as rest, in spacings
void sleeps(const std::string& pressure, double rest) {
    Pool awake(puddle(pressure, 0, 0.2, 1.1)), sleepy(puddle(pressure, rest, 0.2, 1.1));
    awake.run_until(1), sleepy.run_until(1);
    const Index all = awake.simulation.world().fluid.size();
    CHECK(sleepy.simulation.world().fluid.size() == all);
    const Measures a = awake.measures(), s = sleepy.measures();
    // Resting, both: what sleep keeps from moving is less than a twentieth of a spacing of height (m g d/20).
    CHECK(s.potential_energy == Approx(a.potential_energy).margin(0.05 * 0.01 * 9.81 * 1e-3 * static_cast<double>(all)));
    // The puddle is put away but for the nozzle's fluid.
    CHECK(sleepy.solved_for() < 0.2 * static_cast<double>(all));
    // Then more is poured in: the puddle moves where it lands, no particle is lost, and both end at the same height and as dense.
    awake.run_until(1.75), sleepy.run_until(1.75);
    CHECK(sleepy.simulation.world().fluid.size() == awake.simulation.world().fluid.size());
    CHECK(sleepy.measures().potential_energy ==
          Approx(awake.measures().potential_energy).margin(0.1 * 0.01 * 9.81 * 1e-3 * static_cast<double>(all)));
    CHECK(sleepy.measures().density_error_max < awake.measures().density_error_max + 0.1);
}

}  // namespace

TEST_CASE("a settled puddle of honey falls asleep, is not solved for, and keeps its height, what is poured onto it wakes it in time",
          "[validation][sleep]") {
    sleeps("coupled", 0.25);  // its particles turn about by up to 0.15 spacings in half a second
}

TEST_CASE("a puddle with the pressure equation, whose particles go on milling about, falls asleep as one of honey does",
          "[validation][sleep][long]") {
    sleeps("ppe", 1);  // by less than a spacing, which is what has to count as rest there
}

}  // namespace sleep_validation
