/// Effect of the gate at solids on a fall onto a floor.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/support/benchmarks.h"
#include "tests/support/runs.h"

namespace gate_test {

using namespace whorl;
using namespace whorl::test;

namespace {

struct Fall {
    double felt_from = 0;  ///< height of the lowest particle when the floor first slows it [spacings]
    double lowest = 1e9;   ///< the least height of any particle [spacings]
    double rests = 0;      ///< of the lowest layer over the last tenth of the run [spacings]
    double speed = 0;      ///< the largest at the end [m/s]
};

Fall fall(const std::string& pressure, double gate) {
    const Scene scene = shipped_scene("studies/gate", {"models.pressure=" + pressure, "boundary.gate=" + std::to_string(gate),
                                                       "domain.max=[0.05,0.3,0.05]", "block[0].max=[0.05,0.11,0.05]"});
    Simulation simulation(scene, make_plan(scene));
    const double d = scene.fluid.spacing, end = pressure == "wcsph" ? 0.4 : scene.time.end;  // at rest by then
    Fall found;
    int averaged = 0;
    // The lowest layer: particles less than half a spacing above the lowest particle.
    run_until(simulation, end, [&] {
        double lowest = 1e9, height = 0, sum = 0;
        int count = 0;
        const auto at = positions(simulation), u = velocities(simulation);
        for (const Vec3& one : at) lowest = std::min<double>(lowest, one.y());
        for (std::size_t i = 0; i < at.size(); ++i)
            if (at[i].y() < lowest + 0.5 * d) height += at[i].y(), sum += u[i].y(), ++count;
        const double free = -9.81 * simulation.time();
        if (found.felt_from == 0 && sum / count > 0.98 * free) found.felt_from = lowest / d;
        found.lowest = std::min(found.lowest, lowest / d);
        found.speed = largest_speed(u);
        if (simulation.time() > 0.9 * end) found.rests += height / count / d, ++averaged;
    });
    found.rests /= averaged;
    return found;
}

}  // namespace

TEST_CASE("a gated floor acts only in contact, and carries a sheet of water within a tenth of a spacing", "[validation][boundary]") {
    for (const std::string pressure : {"wcsph", "ppe"}) {
        const Fall always = fall(pressure, 0), gated = fall(pressure, 0.1);
        INFO(pressure << ": felt from " << always.felt_from << " and " << gated.felt_from << " d, lowest " << always.lowest << " and "
                      << gated.lowest << " d, rests at " << always.rests << " and " << gated.rests << " d, speed " << always.speed
                      << " and " << gated.speed << " m/s");
        CHECK(gated.felt_from <= std::max(always.felt_from, 0.6));  // particles in contact are at 0.5
        CHECK(gated.lowest > 0);
        CHECK(gated.rests == Approx(always.rests).margin(0.1));
        CHECK(gated.speed < 0.05 * std::sqrt(2 * 9.81 * 0.08));
    }
}

}  // namespace gate_test
