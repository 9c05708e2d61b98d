#include "tools/film/panel_scenes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "engine/probes/comparison.h"
#include "tools/cost/choices.h"
#include "tools/film/exports.h"
#include "tools/scene_file/scene_changes.h"

namespace whorl {
namespace {

/// @throws InputError if no probe of the run has the column of output.chart
void check_chart(const std::string& chart, const FileLocation& place, const Simulation& start) {
    std::vector<std::string> names;
    for (const auto& [name, probe] : make_probes(start, TheorySearch::wait))
        for (const ProbeColumn& column : probe->columns()) names.push_back(name + "." + column.name);
    if (std::find(names.begin(), names.end(), chart) != names.end()) return;
    const std::string near = nearest_name(chart, names);
    throw InputError(place, "no probe measures \"" + chart + "\"", near.empty() ? "" : "did you mean \"" + near + "\"?",
                     "the name of a [[probe]], a dot, and one of its columns");
}

/// Whether one coarse run gives the camera box and colour range of two panels: they differ only in drawing, models, solvers and spacing.
bool flow_alike(const SceneFile& a, const SceneFile& b) {
    const std::vector<std::string> alike{"look", "camera", "output", "surface", "models", "pressure", "viscosity", "micropolar"};
    const std::vector<KeyDifference> all = differences(a, b);
    return std::all_of(all.begin(), all.end(), [&](const KeyDifference& d) {
        return std::find(alike.begin(), alike.end(), d.path.substr(0, d.path.find('.'))) != alike.end() || d.path == "fluid.spacing";
    });
}

/// Sets one range for all panels with the same field and colour map, and one box for all automatic cameras, large enough for each panel.
/// Places the fluid of every panel for this. @throws InputError if a panel's scene is impossible
void share_choices(std::vector<SceneFile>& panels, const Choose& choose) {
    std::map<std::pair<std::string, std::string>, std::array<float, 2>> shared;
    SeenBox extent;
    std::vector<const SceneFile*> seen;
    for (const SceneFile& panel : panels) {
        const Simulation start(panel.scene, make_plan(panel.scene));  // throws if the scene is impossible, before anything is written
        check_probes(start);
        const bool known =
            choose && std::any_of(seen.begin(), seen.end(), [&](const SceneFile* other) { return flow_alike(*other, panel); });
        const bool ranged = !wants_range(panel.look) || (known && shared.count({panel.look.field, panel.look.colour_map}) > 0);
        if (ranged && (!wants_extent(panel) || (known && !extent.isEmpty()))) continue;
        seen.push_back(&panel);
        const SceneFile chosen = choose ? choose(panel, start) : with_estimates(panel, start);
        const auto range = chosen.look.range;
        if (wants_range(panel.look)) {
            const auto [it, first] = shared.try_emplace({panel.look.field, panel.look.colour_map}, range);
            it->second = {std::min(it->second[0], range[0]), std::max(it->second[1], range[1])};
        }
        if (wants_extent(panel) && chosen.camera.min && chosen.camera.max)
            extent.extend(*chosen.camera.min), extent.extend(*chosen.camera.max);
    }
    for (SceneFile& panel : panels) {
        if (wants_range(panel.look)) panel.look.range = shared.at({panel.look.field, panel.look.colour_map});
        if (wants_extent(panel)) look_at(panel.camera, extent);
    }
}

/// Index of the run of the panel with this label. @throws InputError if there is none
int run_called(const std::vector<PanelKeys>& panels, const std::string& label, const FileLocation& place) {
    int run = 0;
    std::vector<std::string> labels;
    for (const PanelKeys& panel : panels) {
        if (!panel.difference.empty()) continue;
        if (panel.label == label) return run;
        labels.push_back(panel.label);
        ++run;
    }
    const std::string near = nearest_name(label, labels);
    throw InputError(place, "no panel with a run has the label \"" + label + "\"",
                     near.empty() ? "set the label of each panel" : "did you mean \"" + near + "\"?");
}

PanelCell difference_of(const SceneFile& file, std::size_t k) {
    const PanelKeys& panel = file.scene.panels[k];
    const FileLocation place = file.scene.place("panel[" + std::to_string(k) + "].difference");
    if (panel.difference.size() != 2)
        throw InputError(place, "a difference needs two panels", "", "two labels, as in [\"no spin\", \"spin\"]");
    if (file.look.style != "slice")
        throw InputError(place, "a difference needs slices, but look.style is \"" + file.look.style + "\"", "use look.style = \"slice\"");
    if (!panel.set.empty()) throw InputError(place, "a difference has no run, so it cannot have set", "remove set or difference");
    PanelCell cell;
    for (int n = 0; n < 2; ++n) cell.between[n] = run_called(file.scene.panels, panel.difference[n], place);
    return cell;
}

}  // namespace

int panel_columns(const Scene& scene) {
    const std::size_t panels = scene.panels.size();
    if (scene.output.panel_columns) return std::min(*scene.output.panel_columns, static_cast<int>(panels));
    if (scene.domain.dimensions == 3)
        return panels <= 3 ? static_cast<int>(panels) : static_cast<int>(std::ceil(std::sqrt(static_cast<double>(panels))));
    // An image of a 2D flow shows the whole domain: choose the columns that show it largest.
    const Vec3d size = scene.domain.max - scene.domain.min;
    const auto scale = [&](int columns) {
        const int rows = (static_cast<int>(panels) + columns - 1) / columns;
        return std::min(scene.output.size[0] / (columns * size.x()), (scene.output.size[1] - chart_height(scene)) / (rows * size.y()));
    };
    int best = 1;
    for (int columns = 2; columns <= static_cast<int>(panels); ++columns)
        if (scale(columns) > scale(best)) best = columns;
    return best;
}

int chart_height(const Scene& scene) { return scene.output.chart.empty() ? 0 : scene.output.size[1] / 4 / 2 * 2; }

float panel_text(const SceneFile& file) {
    const auto width = static_cast<float>(file.scene.output.size[0]);
    return file.look.text_size > 0 ? file.look.text_size : std::max(9.0f, std::round(width / 91));
}

std::vector<PanelCell> panel_cells(const SceneFile& file) {
    std::vector<PanelCell> cells;
    int runs = 0;
    for (std::size_t k = 0; k < file.scene.panels.size(); ++k) {
        if (file.scene.panels[k].difference.empty()) cells.push_back({runs++});
        else cells.push_back(difference_of(file, k));
    }
    return cells;
}

std::vector<SceneFile> panel_scenes(const SceneFile& file, const Choose& choose) {
    const int count = static_cast<int>(file.scene.panels.size()), columns = panel_columns(file.scene);
    const int rows = (count + columns - 1) / columns;
    const auto check_format = [](const Scene& scene, const FileLocation& place) {
        if (scene.output.format != "png")
            throw InputError(place, "output.format = \"" + scene.output.format + "\" has no text, but panels need their labels",
                             "remove it, or render the scene of one panel alone", "allowed: png");
    };
    const auto check_pictures = [](const Scene& panel, const Scene& plain) {
        if (panel.output.size != plain.output.size)
            throw InputError({}, "all panels have the same size, a part of the whole image",
                             "set output.size in [output], for the whole image");
        if (panel.output.images != plain.output.images)
            throw InputError({}, "a panel without images leaves its part of the video empty",
                             "set output.images in [output], for all panels");
    };
    check_format(file.scene, file.scene.place("output.format"));
    SceneFile alone = file;
    alone.scene.panels.clear();
    alone.scene.output.video = false;
    alone.scene.output.chart.clear();
    // Even sizes, so that each could be a separate video.
    alone.scene.output.size = {(file.scene.output.size[0] - (columns - 1) * panel_gap) / columns / 2 * 2,
                               (file.scene.output.size[1] - chart_height(file.scene) - (rows - 1) * panel_gap) / rows / 2 * 2};
    alone.look.text_size = panel_text(file);
    const std::vector<PanelKeys>& panels = file.scene.panels;
    const bool differences = std::any_of(panels.begin(), panels.end(), [](const PanelKeys& panel) { return !panel.difference.empty(); });
    if (differences && file.scene.output.images) export_raw(alone.scene);  // a difference is drawn from raw frames
    std::vector<SceneFile> scenes;
    std::vector<Problem> problems;
    for (int k = 0; k < count; ++k) {
        if (!file.scene.panels[k].difference.empty()) continue;
        const std::string name = "panel[" + std::to_string(k) + "].set";
        try {
            std::vector<KeyValue> changes;
            for (const std::string& text : file.scene.panels[k].set) changes.push_back(parse_change(text, name));
            scenes.push_back(changed(alone, changes));
            check_format(scenes.back().scene, {});
            check_pictures(scenes.back().scene, alone.scene);
            if (scenes.back().look.title.empty()) scenes.back().look.title = file.scene.panels[k].label;
            scenes.back().scene.places = file.scene.places;  // so that its errors name locations in the file
        } catch (const InputError& error) {
            for (Problem problem : error.problems()) {
                problem.place = file.scene.place(name);
                problem.what = name + ": " + problem.what;
                problems.push_back(std::move(problem));
            }
        }
    }
    if (!problems.empty()) throw InputError(std::move(problems));
    if (scenes.empty()) throw InputError(file.scene.place("panel[0].difference"), "no panel has a run");
    panel_cells(file);
    for (const SceneFile& run : scenes)
        if (!file.scene.output.chart.empty())
            check_chart(file.scene.output.chart, file.scene.place("output.chart"), Simulation(run.scene, make_plan(run.scene)));
    share_choices(scenes, choose);
    return scenes;
}

std::vector<std::string> warnings_of(const SceneFile& file) {
    if (file.scene.panels.empty()) return make_plan(file).warnings;
    std::vector<std::vector<std::string>> of_run;
    for (const SceneFile& run : panel_scenes(file)) of_run.push_back(make_plan(run).warnings);
    const auto of_all = [&](const std::string& warning) {
        return std::all_of(of_run.begin(), of_run.end(),
                           [&](const auto& own) { return std::find(own.begin(), own.end(), warning) != own.end(); });
    };
    std::vector<std::string> warnings;
    for (std::size_t k = 0; k < of_run.size(); ++k)
        for (const std::string& warning : of_run[k])
            if (!of_all(warning)) warnings.push_back(fmt::format("panel {}: {}", k + 1, warning));
            else if (k == 0) warnings.push_back(warning);
    return warnings;
}

SceneFile with_choices_of(SceneFile file, const std::vector<SceneFile>& runs) {
    const bool coloured = file.look.range[0] == file.look.range[1];
    std::size_t k = 0;
    for (PanelKeys& panel : file.scene.panels) {
        if (!panel.difference.empty()) continue;
        const SceneFile& run = runs.at(k++);
        const auto give = [&](const std::string& key, std::initializer_list<float> numbers) {
            const bool given = std::any_of(panel.set.begin(), panel.set.end(), [&](const std::string& s) { return s.rfind(key, 0) == 0; });
            Value::List list;
            for (const float x : numbers) list.emplace_back(shortest_decimal(x));
            if (!given) panel.set.push_back(key + "=" + Value(list).toml());
        };
        const auto &min = run.camera.min, &max = run.camera.max;
        if (coloured && shows_field(run.look)) give("look.range", {run.look.range[0], run.look.range[1]});
        if (!min || min == file.camera.min) continue;
        give("camera.min", {min->x(), min->y(), min->z()});
        give("camera.max", {max->x(), max->y(), max->z()});
    }
    return file;
}

}  // namespace whorl
