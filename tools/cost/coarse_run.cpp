#include "tools/cost/coarse_run.h"

#include <fmt/format.h>

#include "engine/io/snapshot.h"
#include "engine/scene/frame_times.h"
#include "tools/scene_file/scene_changes.h"

namespace whorl {

bool run_coarsely(const SceneFile& file, double coarser, int moments, const std::vector<std::string>& fields,
                  const std::function<void(const Frame&, const Simulation&)>& show) try {
    const std::string spacing = fmt::format("fluid.spacing={:.9g}", coarser * file.scene.fluid.spacing);
    const SceneFile coarse = changed(file, {read_change(parse_change(spacing))});
    Simulation simulation(coarse.scene, make_plan(coarse.scene));
    const Snapshots snapshots(simulation, fields);
    const double first = frame_time(file.scene, 1), last = frame_time(file.scene, frame_count(file.scene));
    show(snapshots.take(simulation, 1), simulation);
    for (int k = 1; k <= moments; ++k) {
        const double time = first + k * (last - first) / moments;
        while (simulation.time() < time)
            if (simulation.step(time).diverged) return false;
        show(snapshots.take(simulation, 1), simulation);
    }
    return true;
} catch (const InputError&) { return false; }

}  // namespace whorl
