#pragma once
/// Output of `whorl plan` and `whorl render --dry-run`.
#include <filesystem>
#include <optional>

#include "engine/simulation/simulation.h"
#include "tools/cost/coarse_run.h"
#include "tools/scene_file/scene_file.h"

namespace whorl {

/// Data to print about a scene at its start.
struct Preview {
    const SceneFile& file;
    const Plan& plan;
    const Simulation& simulation;
    // Only for `whorl plan`:
    std::optional<CoarseRun> coarse = {};  ///< of the scene or its last panel
    Estimate cost = {};                    ///< of the scene or its last panel; with panels, film times are sums and memory is the maximum
    // Only for `whorl render --dry-run`:
    int frames = 0;
    std::filesystem::path folder = {};  ///< run folder
};

void print_preview(const Preview& preview, bool json);

}  // namespace whorl
