#include "tests/support/runs.h"

#include <sstream>
#include <stdexcept>

#include "engine/scene/read.h"

namespace whorl::test {

Simulation simulation_of(const std::string& text) {
    const Scene scene = read_scene_text(text, "test.toml");
    return Simulation(scene, make_plan(scene));
}

void run_until(Simulation& simulation, double end) {
    while (simulation.time() < end)
        if (simulation.step(end).diverged) throw std::runtime_error("the run diverged");
}

std::string state_of(const Simulation& simulation) {
    std::ostringstream out;
    simulation.save(out);
    return out.str();
}

}  // namespace whorl::test
