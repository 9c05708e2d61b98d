#pragma once
/// Output of `whorl plan` and `whorl render --dry-run`.
#include <filesystem>
#include <optional>

#include "engine/sim/simulation.h"
#include "tools/cost/estimate.h"
#include "tools/scene_file/scene_file.h"

namespace whorl {

/// Cost of all panels together.
struct FilmCost {
    double wall = 0;                             ///< s
    double simulate = 0, surface = 0, draw = 0;  ///< CPU seconds
};

struct PreviewCost {
    CoarseRun run;      ///< of the last panel
    Estimate estimate;  ///< of the last panel, but the memory of all
    FilmCost film;
};

/// Files of a run.
struct PreviewRun {
    int frames = 0;
    std::filesystem::path folder;
};

/// A scene at its start, and the limits of its first step.
struct Preview {
    const SceneFile& file;
    const Plan& plan;
    const Simulation& simulation;
    std::optional<PreviewCost> cost = {};  ///< of `whorl plan`
    std::optional<PreviewRun> run = {};    ///< of `whorl render --dry-run`
};

void print_text(const Preview& preview);
void print_json(const Preview& preview);

}  // namespace whorl
