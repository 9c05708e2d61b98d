#pragma once
/// The table of a probe as plots: a diagram for each title that its columns have.
#include <filesystem>

#include "engine/probes/comparison.h"
#include "render/image/canvas.h"

namespace whorl {

/// Curves over time; of a probe that measures several places a frame, curves over the place at some of the frames. Theory is dashed, a
/// comparison dotted. @param table as a run has written it
Canvas plot_of_table(const std::string& title, const Probe& probe, const std::filesystem::path& table,
                     const std::optional<Comparison>& comparison);

}  // namespace whorl
