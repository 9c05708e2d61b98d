// Starts scenes that are small enough: places particles, makes a step, queries the probes, builds the surface.
#include "tests/fuzz/small_run.h"
#include "tools/scene_file/scene_file.h"

using namespace whorl;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    try {
        const SceneFile file = read_resolved(std::string(fuzz::text_of(data, size)), fuzz::scratch() / "scene.toml");
        const Plan plan = make_plan(file.scene);
        if (!fuzz::is_small(file.scene, plan)) return 0;
        Simulation simulation(file.scene, plan);
        const NamedProbes probes = make_probes(simulation, TheorySearch::in_background);
        fuzz::step_once(simulation, probes);
        fuzz::surface_of(Snapshots(simulation, {"age", "grain"}).take(simulation, 1), file.surface);
    } catch (const InputError& error) { fuzz::expect(*error.what() != 0, "a mistake has words"); }
    return 0;
}
