#pragma once
/// Runs and cells of a video of panels ([[panel]]).
#include <array>
#include <functional>
#include <vector>

#include "engine/simulation/simulation.h"
#include "tools/scene_file/scene_file.h"

namespace whorl {

/// Returns `run` with its colour range and camera box set.
using Choose = std::function<SceneFile(const SceneFile& run, const Simulation& start)>;
/// Scenes of the panels that are runs, with the panels' keys set and images of the size of a cell. Panels that show the same field with the
/// same colour map share its range, so that equal colours mean equal values. Automatic cameras share their box.
/// @param choose empty: ranges and boxes are estimates, which suffice for a plan @throws InputError with the problems of all panels' keys
std::vector<SceneFile> panel_scenes(const SceneFile& file, const Choose& choose = {});

/// Warnings of the scene's plan or, if it has panels, of the plans of its panels. A warning names its panel unless all panels have it.
/// @throws InputError if a plan is impossible
std::vector<std::string> warnings_of(const SceneFile& file);

/// A cell of the video.
struct PanelCell {
    int run = -1;                        ///< index of its run; -1: a difference of two runs
    std::array<int, 2> between{-1, -1};  ///< indices of the runs of a difference
};
/// Cells of the panels, in the order of the scene. @throws InputError if a difference names a panel without a run
std::vector<PanelCell> panel_cells(const SceneFile& file);

/// Number of panels per row: output.panel_columns if it is set; in 2D the number that shows the flow largest; in 3D all panels if there are
/// at most three, otherwise the square root of their number, rounded up.
int panel_columns(const Scene& scene);

/// Height of the chart under the panels [pixels]; 0: none.
int chart_height(const Scene& scene);

/// Height of a capital letter in all panels and the chart [pixels].
float panel_text(const SceneFile& file);

constexpr int panel_gap = 4;  ///< pixels between panels

/// The file with the colour ranges and camera boxes of `runs` as keys of its panels, so that it gives the same images again.
/// @param runs result of panel_scenes()
SceneFile with_choices_of(SceneFile file, const std::vector<SceneFile>& runs);

}  // namespace whorl
