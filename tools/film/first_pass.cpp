#include "tools/film/first_pass.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "engine/io/snapshot.h"
#include "engine/scene/frame_times.h"
#include "render/look/colour_map.h"
#include "render/look/field_values.h"
#include "tools/cost/coarse_run.h"
#include "tools/film/colour_range.h"
#include "tools/film/film_extent.h"
#include "tools/scene_file/scene_changes.h"

namespace whorl {
namespace {

/// What 99 % of the values stay below in size.
float usual_size(std::vector<float> values) {
    std::erase_if(values, [](float v) { return !std::isfinite(v); });
    if (values.empty()) return 0;
    for (float& v : values) v = std::abs(v);
    const auto usual = values.begin() + static_cast<std::ptrdiff_t>(values.size() * 99 / 100);
    std::nth_element(values.begin(), usual, values.end());
    return *usual;
}

struct Seen {
    float size = 0;  ///< of the look's field
    Extent extent;
};

/// @return nothing where the coarse scene is impossible or diverges
std::optional<Seen> seen_in_a_coarse_run(const SceneFile& file) {
    constexpr int moments = 24;
    const bool field = shows_field(file.look);
    Seen seen;
    std::optional<Frame> start;
    const auto look = [&](const Frame& frame, const Simulation&) {
        if (!start) start = frame;
        if (field) seen.size = std::max(seen.size, usual_size(field_values(frame, file.look)));
        add_seen(seen.extent, frame, *start);
    };
    if (!run_coarsely(file, 2, moments, field ? std::vector{file.look.field} : std::vector<std::string>{}, look)) return {};
    add_still_solids(seen.extent, *start);
    return seen;
}

}  // namespace

SceneFile with_estimates(SceneFile file, const Simulation& start) {
    if (wants_range(file.look)) file.look.range = film_range(file.look, start);
    if (wants_extent(file)) look_at(file.camera, foreseen_extent(start));
    return file;
}

SceneFile with_first_pass(SceneFile file, const Simulation& start, bool quiet) {
    const LookOptions& look = file.look;
    const bool may_run = file.scene.output.frames && file.scene.changes.empty();
    const bool measure = may_run && wants_range(look) && look.field != "density" && look.field != "ink";
    const bool watch = may_run && wants_extent(file);
    std::optional<Seen> seen;
    if (measure || watch) {
        const char* what = measure && watch ? "colours' range and the camera" : measure ? "colours' range" : "camera";
        if (!quiet) fmt::print(stderr, "first pass at twice the spacing, for the {}\n", what);
        seen = seen_in_a_coarse_run(file);
    }
    if (watch && seen) look_at(file.camera, seen->extent);
    if (measure && seen && seen->size > 0) {
        const auto high = static_cast<float>(round_number_above(seen->size));
        file.look.range = {is_diverging(look.colour_map) ? -high : 0.0f, high};
    }
    return with_estimates(std::move(file), start);
}

}  // namespace whorl
