#pragma once
/// The runs and the pictures of a film of panels, as its scene has them.
#include <array>
#include <functional>
#include <vector>

#include "engine/simulation/simulation.h"
#include "tools/scene_file/scene_file.h"

namespace whorl {

/// The scenes of those panels that are runs: their keys put in, pictures as large as their place. Panels that show the same field through
/// the same map share its range, so that equal colours mean equal values, and automatic cameras share their box.
/// @throws InputError with the problems of a panel's keys
/// @param choose gives a run its range and its box; by default an estimate, which is enough for a plan
using Choose = std::function<SceneFile(const SceneFile& run, const Simulation& start)>;
std::vector<SceneFile> panel_scenes(const SceneFile& file, const Choose& choose = {});

/// Warnings of the plans of a film's runs: the scene's, or its panels', each with its panel unless all have it. @throws InputError
/// if one is impossible
std::vector<std::string> warnings_of(const SceneFile& file);

/// A place in the film.
struct PanelCell {
    int run = -1;                        ///< its number among the runs; -1: a difference
    std::array<int, 2> between{-1, -1};  ///< the runs of a difference
};
/// One a panel, in the scene's order. @throws InputError if a difference names a panel without a run
std::vector<PanelCell> panel_cells(const SceneFile& file);

/// Number of panels in a row: as the scene specifies; in 2D the number that makes the flow largest; else all of two or three, from four on
/// about the number of rows.
int panel_columns(const Scene& scene);

/// Height of the chart under the panels [pixels]; 0: none.
int chart_height(const Scene& scene);

constexpr int panel_gap = 4;  ///< pixels between panels

/// The file with what its panels' runs were given, ranges of colours and boxes of cameras, so that it makes the same pictures again.
/// @param runs of panel_scenes()
SceneFile with_choices_of(SceneFile file, const std::vector<SceneFile>& runs);

}  // namespace whorl
