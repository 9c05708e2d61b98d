#include "tests/support/runs.h"

#include <sstream>

#include "engine/core/parallel.h"
#include "engine/scene/read.h"

namespace whorl::test {

Simulation simulation_of(const std::string& text) {
    const Scene scene = read_scene_text(text, "test.toml");
    return Simulation(scene, make_plan(scene));
}

std::string state_of(const Simulation& simulation) {
    std::ostringstream out;
    simulation.save(out);
    return out.str();
}

std::string differing_bits(const std::string& text, double end) {
    const int before = threads();
    set_threads(1);
    Simulation whole = simulation_of(text);
    run_until(whole, end / 2);
    const std::string half_way = state_of(whole);
    run_until(whole, end);
    set_threads(4);
    Simulation more_threads = simulation_of(text), resumed = simulation_of(text);
    run_until(more_threads, end / 2);
    std::istringstream saved(half_way);
    resumed.load(saved);
    run_until(resumed, end);
    set_threads(before);
    if (state_of(more_threads) != half_way) return "half-way on 4 threads";
    return state_of(resumed) == state_of(whole) ? "" : "at the end of a run that was saved half-way and continued on 4 threads";
}

}  // namespace whorl::test
