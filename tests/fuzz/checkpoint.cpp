// Checkpoints, and runs that continue from them.
#include "engine/io/checkpoint.h"

#include <sstream>

#include "engine/io/csv.h"
#include "engine/scene/plan.h"
#include "tests/fuzz/checksummed.h"
#include "tests/fuzz/small_run.h"
#include "tools/scene_file/scene_file.h"

using namespace whorl;

namespace {

constexpr std::string_view kind = "WHORLCP3";

// Every part of a checkpoint: fluid with a source and an age, an emitter, a free body, probes with a state.
const char* const scene_text = R"(
[time]
end = 1
[domain]
min = [-0.05, -0.01, -0.05]
max = [0.05, 0.1, 0.05]
[fluid]
spacing = 0.01
viscosity = "10+age"
[[block]]
shape = "box"
min = [-0.01, 0, -0.01]
max = [0.01, 0.02, 0.01]
[[emitter]]
position = [0, 0.06, 0]
radius = 0.01
speed = 0.5
profile = "parabolic"
viscosity = 5
[[solid]]
shape = "box"
min = [-0.03, -0.01, -0.03]
max = [0.03, 0, 0.03]
[[solid]]
shape = "sphere"
radius = 0.01
position = [0.03, 0.04, 0]
density = 500
[[probe]]
kind = "coil"
name = "coil"
[[probe]]
kind = "solid"
solid = 1
name = "ball"
[output]
export = ["points"]
)";

const Scene& little_scene() {
    static const SceneFile file = read_resolved(scene_text, "scene.toml");
    return file.scene;
}

const Plan& little_plan() {
    static const Plan plan = make_plan(little_scene());
    return plan;
}

struct Run {
    Simulation simulation;
    NamedProbes probes;
    Run() : simulation(little_scene(), little_plan()), probes(make_probes(simulation, TheorySearch::in_background)) {}
};

/// A checkpoint saved by this program, not a file of the corpus, which would become outdated.
std::string new_checkpoint() {
    Run run;
    while (run.simulation.time() < frame_time(little_scene(), 2)) fuzz::step_once(run.simulation, run.probes);
    Checkpoint made;
    made.build = build_id(), made.scene = scene_text, made.frame = 2, made.frames = 24;
    for (const auto& [name, probe] : run.probes) {
        std::ostringstream memory;
        probe->save(memory);
        made.probes[name] = memory.str();
    }
    std::ostringstream state;
    run.simulation.save(state);
    made.simulation = state.str();
    write_checkpoint(fuzz::scratch(), made);
    return read_whole(fuzz::scratch() / "checkpoints" / "000002.whorl");
}

Checkpoint from_bytes(std::string_view bytes) { return read_checkpoint(fuzz::as_file(bytes, ".whorl")); }

void go_on(const Checkpoint& from) {
    Run run;
    std::istringstream state(from.simulation);
    run.simulation.load(state);
    for (const auto& [name, probe] : run.probes)
        if (const auto found = from.probes.find(name); found != from.probes.end()) {
            std::istringstream memory(found->second);
            probe->load(memory);
        }
    fuzz::step_once(run.simulation, run.probes);
}

}  // namespace

std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most, unsigned seed) {
    static const std::string fresh = new_checkpoint();
    if (seed % 64 == 1 && fresh.size() <= most) size = fresh.copy(reinterpret_cast<char*>(data), most);
    return fuzz::mutate_sealed(kind, data, size, most, seed / 64);
}

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    try {
        go_on(from_bytes(fuzz::text_of(data, size)));
    } catch (const EnvironmentError& error) {
        fuzz::expect(*error.what() != 0, "a refusal has words");
        return 0;
    }
    fuzz::expect_refusal_of_changes(std::string(fuzz::text_of(data, size)), from_bytes);
    return 0;
}
