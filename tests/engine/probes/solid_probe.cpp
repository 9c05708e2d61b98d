// The probe of forces on a solid, computed from the ledger.
#include <catch2/catch.hpp>
#include <cmath>
#include <sstream>

#include "engine/geometry/shape.h"
#include "engine/probes/experiments.h"
#include "tests/support/solids.h"

using namespace whorl;

namespace solid_probe_test {

namespace {

/// One step of length dt [s] in which the fluid pushes the ball at (0, 1, 0) from its centre along x and z.
void step(World& world, Probe& probe, double dt, double along_x, double along_z) {
    world.solids.clear_ledgers();
    world.step.dt = static_cast<Real>(dt);
    world.solids.all[0].receive(Push::pressure, Wrench::at({0, 1, 0}, {along_x, 0, 0}));
    world.solids.all[0].receive(Push::contact, Wrench::at({0, 1, 0}, {0, 0, along_z}));
    probe.after_step(world, 0);
}

World with_ball() {
    World world;
    world.solids.all.push_back(test::solid_of(make_sphere({0, 0, 0}, 1)));
    world.solids.set_time(0, 1e-3);
    return world;
}

}  // namespace

TEST_CASE("a solid probe reports impulse over time since its last row, and the peak of a step", "[probe]") {
    World world = with_ball();
    const auto probe = make_solid_probe({});
    const ProbeColumns columns = probe->columns();
    const auto value = [&](const std::vector<double>& row, const std::string& name) {
        return row.at(static_cast<std::size_t>(
            std::find_if(columns.begin(), columns.end(), [&](const ProbeColumn& c) { return c.name == name; }) - columns.begin()));
    };
    CHECK(std::isnan(probe->rows(world, 0).at(0).at(1)));
    step(world, *probe, 0.25, 1, 2);
    step(world, *probe, 0.75, 3, 0);
    const std::vector<double> row = probe->rows(world, 1).at(0);
    REQUIRE(row.size() == columns.size());
    CHECK(value(row, "pressure_x") == Approx(4));
    CHECK(value(row, "viscous_x") == 0);
    CHECK(value(row, "contact_z") == Approx(2));
    CHECK(value(row, "torque_z") == Approx(-4));
    CHECK(value(row, "torque_x") == Approx(2));
    CHECK(value(row, "peak") == Approx(std::hypot(1, 2) / 0.25));
    step(world, *probe, 0.5, -1, 0);
    CHECK(value(probe->rows(world, 1.5).at(0), "pressure_x") == Approx(-2));
}

TEST_CASE("a solid probe that is resumed between rows reports the same row", "[probe]") {
    World world = with_ball();
    const auto probe = make_solid_probe({}), resumed = make_solid_probe({});
    step(world, *probe, 0.25, 1, 2);
    std::stringstream state;
    probe->save(state);
    resumed->load(state);
    step(world, *probe, 0.5, 5, 1);
    step(world, *resumed, 0.5, 5, 1);
    CHECK(probe->rows(world, 1) == resumed->rows(world, 1));
    CHECK_THROWS_WITH(resumed->load(state), Catch::Contains("not valid for a solid probe"));  // the sums are empty
}

}  // namespace solid_probe_test
