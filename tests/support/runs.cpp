#include "tests/support/runs.h"

#include <catch2/catch.hpp>
#include <sstream>

#include "engine/scene/read.h"

namespace whorl::test {

Simulation simulation_of(const std::string& text) {
    const Scene scene = read_scene_text(text, "test.toml");
    return Simulation(scene, make_plan(scene));
}

void run_until(Simulation& simulation, double end) {
    while (simulation.time() < end) REQUIRE_FALSE(simulation.step(end).diverged);
}

std::string state_of(const Simulation& simulation) {
    std::ostringstream out;
    simulation.save(out);
    return out.str();
}

}  // namespace whorl::test
