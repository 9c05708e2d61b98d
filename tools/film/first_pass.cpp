#include "tools/film/first_pass.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "engine/core/errors.h"
#include "render/look/colour_map.h"
#include "render/look/field_values.h"
#include "tools/cost/coarse_run.h"
#include "tools/film/colour_range.h"
#include "tools/film/contact_sheet.h"
#include "tools/film/film_extent.h"
#include "tools/film/progress.h"

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

/// Density keeps to an estimate, inks have no range.
bool measures_range(const LookOptions& look) { return wants_range(look) && look.field != "density" && look.field != "ink"; }

/// What frames of a film show, the first of them first.
class Seen {
public:
    explicit Seen(const LookOptions& look) : look_(look) {}
    void add(const Frame& frame) {
        if (!start_) start_ = frame;
        if (shows_field(look_)) size_ = std::max(size_, usual_size(field_values(frame, look_)));
        add_seen(extent_, frame, *start_);
    }
    /// Puts them into what the scene leaves open.
    void choose(SceneFile& file) {
        if (start_) add_still_solids(extent_, *start_);
        if (wants_extent(file)) look_at(file.camera, extent_);
        if (!measures_range(file.look) || !(size_ > 0)) return;
        const auto high = static_cast<float>(round_number_above(size_));
        file.look.range = {is_diverging(file.look.colour_map) ? -high : 0.0f, high};
    }

private:
    LookOptions look_;
    std::optional<Frame> start_;
    float size_ = 0;  ///< of the look's field
    Extent extent_;
};

constexpr int moments = 24;

}  // namespace

SceneFile with_estimates(SceneFile file, const Simulation& start) {
    if (wants_range(file.look)) file.look.range = film_range(file.look, start);
    if (wants_extent(file)) look_at(file.camera, foreseen_extent(start));
    return file;
}

SceneFile with_first_pass(SceneFile file, const Simulation& start, bool quiet) {
    const bool measure = file.scene.output.frames && measures_range(file.look), watch = file.scene.output.frames && wants_extent(file);
    if (measure || watch) {
        const char* what = measure && watch ? "colours' range and the camera" : measure ? "colours' range" : "camera";
        if (!quiet) fmt::print(stderr, "first pass at twice the spacing, for the {}\n", what);
        Seen seen(file.look);
        const std::vector<std::string> fields = shows_field(file.look) ? std::vector{file.look.field} : std::vector<std::string>{};
        // Nothing is seen where the coarse scene is impossible or diverges.
        PartProgress progress("first pass", quiet);
        const auto show = [&](const Frame& frame, const Simulation&) { seen.add(frame); };
        if (run_coarsely(file, 2, moments, fields, show, [&](double part) { progress.done(part); })) seen.choose(file);
    }
    return with_estimates(std::move(file), start);
}

SceneFile with_choices_from(SceneFile file, const std::filesystem::path& run, const std::vector<int>& frames) {
    const int count = static_cast<int>(frames.size()), looked_at = std::min(count, moments);
    if (measures_range(file.look) || wants_extent(file)) {
        Seen seen(file.look);
        for (int n = 0; n < looked_at; ++n) seen.add(exported_frame(run, frames[n * (count - 1) / std::max(1, looked_at - 1)]));
        seen.choose(file);
    }
    if (wants_range(file.look) && file.look.field == "density") file.look.range = density_range(file.scene);
    if (!wants_range(file.look) && !wants_extent(file) && !wants_streak_time(file.look)) return file;
    try {
        const Simulation start(file.scene, make_plan(file.scene));
        file.look.streak_time = film_streak_time(file.look, start);
        return with_estimates(file, start);
    } catch (const InputError&) {  // this machine can draw what it has too little memory to simulate: each frame goes by itself
        return file;
    }
}

}  // namespace whorl
