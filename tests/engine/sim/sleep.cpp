/// Fluid at rest sleeps: it costs nothing, stays where it is, and wakes in time.
#include "engine/sim/sleep.h"

#include <sstream>

#include "engine/core/parallel.h"
#include "tests/support/runs.h"
#include "tests/support/puddle.h"

using namespace whorl;
using namespace whorl::test;
using test::Pool;
using test::puddle;

TEST_CASE("a settled puddle falls asleep and is not solved for, what is poured onto it wakes it", "[sleep]") {
    Pool pool(puddle("coupled", 0.05, 0.06, 1.05));
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
