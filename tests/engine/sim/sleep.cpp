/// Fluid at rest sleeps: it costs nothing, stays where it is, and wakes in time.
#include "engine/sim/sleep.h"

#include <sstream>

#include "engine/core/parallel.h"
#include "tests/support/puddle.h"
#include "tests/support/runs.h"

using namespace whorl;
using namespace whorl::test;
using test::Pool;
using test::puddle;

TEST_CASE("a settled puddle falls asleep and is not solved for, what is poured onto it wakes it", "[sleep]") {
    Pool pool(puddle("coupled", 0.25, 0.06, 1.05));
    pool.run_until(1);
    const Index all = pool.size();
    const double height = pool.measures().potential_energy;
    CHECK(pool.solved_for() < 0.5 * static_cast<double>(all));  // the nozzle's fluid is awake
    CHECK(pool.size() == all);
    CHECK(pool.measures().potential_energy == Approx(height));
    pool.run_until(1.4);
    CHECK(pool.size() > all);
    CHECK(pool.solved_for() == Approx(static_cast<double>(pool.size())).epsilon(0.05));
}

TEST_CASE("a run that sleeps is the same for any number of threads and after a resume", "[sleep]") {
    const std::string text = puddle("ppe", 1, 0.12, 0.6);
    const int before = threads();
    set_threads(1);
    Pool whole(text), half(text);
    whole.run_until(0.75);
    half.run_until(0.625);
    set_threads(2);
    Pool other(text);
    std::istringstream in(state_of(half.simulation));
    other.simulation.load(in);
    other.run_until(0.75);
    CHECK(state_of(whole.simulation) == state_of(other.simulation));
    set_threads(before);
}

TEST_CASE("what sleep cannot go with is refused", "[sleep]") {
    const Scene scene = read_scene_text(puddle("ppe", 0.05, 0.1, 1) + "[[drain]]\nshape = \"sphere\"\nradius = 0.01\n", "puddle.toml");
    CHECK_THROWS_WITH(make_plan(scene), Catch::Contains("time.sleep puts away fluid that a drain has to see at every step"));
}

TEST_CASE(
    "what creeps by less than counts as rest in half a second falls asleep, however far it has crept and whenever its neighbours stopped",
    "[sleep]") {
    // A row of particles a spacing apart. Each slides fast until a time of its own, then all creep on: by a half of what counts as rest in
    // half a second, or by twice as much.
    for (const double part : {0.5, 2.0}) {
        CAPTURE(part);
        constexpr Index n = 40;
        constexpr double rest = 0.09, dt = 0.01, d = 0.01;
        World world;
        world.fluid.declare(field_info<field::position>(), true);
        world.fluid.declare(field_info<field::velocity>(), true);
        world.fluid.declare(field_info<field::role>(), true);
        world.fluid.declare(field_info<field::anchor>(), true);
        world.fluid.declare(field_info<field::quiet_time>(), true);
        world.fluid.resize(n);
        world.step.spacing = static_cast<Real>(d), world.step.support = static_cast<Real>(2 * d);
        world.step.domain = Domain{Vec3(-1, -1, -1), Vec3(1, 1, 1)};
        const auto x = world.fluid.column<field::position>();
        for (Index i = 0; i < n; ++i) x[i] = Vec3(static_cast<Real>(d * i), 0, 0);
        Sleep sleep({static_cast<Real>(rest)});
        for (int look = 0; look < 400; ++look) {
            const auto quiet = world.fluid.column<field::quiet_time>();
            for (Index i = 0; i < n; ++i)
                if (quiet[i] >= 0) x[i].y() += static_cast<Real>(dt * (look < 37 * i % 100 ? 0.1 : part * rest * d / 0.5));
            sleep.look(world, dt);
        }
        CHECK(sleep.sleepers() == (part < 1 ? n : 0));
    }
}
