#include "tools/film/first_pass.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "engine/io/snapshot.h"
#include "engine/scene/frame_times.h"
#include "render/look/colour_map.h"
#include "render/look/field_values.h"
#include "tools/film/colour_range.h"
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

/// @return nothing where the coarse scene is impossible or diverges
std::optional<float> largest_in_a_coarse_run(const SceneFile& file, int frames) try {
    constexpr int moments = 24;
    const SceneFile coarse = changed(file, {read_change(parse_change(fmt::format("fluid.spacing={:.9g}", 2 * file.scene.fluid.spacing)))});
    Simulation simulation(coarse.scene, make_plan(coarse.scene));
    const Snapshots snapshots(simulation, {file.look.field});
    float most = usual_size(field_values(snapshots.take(simulation, 1), file.look));
    for (int k = 1; k <= moments; ++k) {
        const double time = frame_time(file.scene, 1) + k * (frame_time(file.scene, frames) - frame_time(file.scene, 1)) / moments;
        while (simulation.time() < time)
            if (simulation.step(time).diverged) return {};
        most = std::max(most, usual_size(field_values(snapshots.take(simulation, 1), file.look)));
    }
    return most;
} catch (const InputError&) { return {}; }

}  // namespace

std::array<float, 2> first_pass_range(const SceneFile& file, const Simulation& start, int frames, bool quiet) {
    const LookOptions& look = file.look;
    const std::array<float, 2> estimate = film_range(look, start);
    if (look.range[0] != look.range[1] || look.field == "density" || look.field == "ink" || !file.scene.changes.empty()) return estimate;
    if (!quiet) fmt::print(stderr, "first pass at twice the spacing, for the colours' range\n");
    const std::optional<float> most = largest_in_a_coarse_run(file, frames);
    if (!most || !(*most > 0)) return estimate;
    const auto high = static_cast<float>(round_number_above(*most));
    return {is_diverging(look.colour_map) ? -high : 0.0f, high};
}

}  // namespace whorl
