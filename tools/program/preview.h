#pragma once
/// Output of `whorl plan` and `whorl render --dry-run`.
#include <filesystem>
#include <optional>

#include "engine/simulation/simulation.h"
#include "tools/cost/estimate.h"
#include "tools/scene_file/scene_file.h"

namespace whorl {

/// A scene at its start, and the limits of its first step.
struct Preview {
    const SceneFile& file;
    const Plan& plan;
    const Simulation& simulation;
    // Of `whorl plan`:
    std::optional<CoarseRun> coarse = {};  ///< of the last panel
    Estimate cost = {};                    ///< of the last panel, but the time and the memory of all, which run one after the other
    // Of `whorl render --dry-run`:
    int frames = 0;
    std::filesystem::path folder = {};
};

void print_preview(const Preview& preview, bool json);

}  // namespace whorl
