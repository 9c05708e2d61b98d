#include <fmt/format.h>

#include "engine/scene/checks.h"
#include "engine/scene/names.h"
#include "engine/scene/read.h"
#include "engine/scene/tree.h"

namespace whorl {
namespace {

/// The scene with the plan's choices in place of "auto".
Scene with_choices(const Scene& scene, const Plan& plan) {
    Scene chosen = scene;
    chosen.models = plan.chosen_models(scene.models);
    if (plan.traits.pressure.form) chosen.pressure.form = plan.traits.pressure.form;
    return chosen;
}

/// The key that disables this one: its selector, or the selector's selector.
const Key& deciding_key(const Key& key, const Described& chosen) {
    const Selector selector = selector_of(key, chosen, chosen);
    return counts(*selector.key, selector.in, chosen) ? key : deciding_key(*selector.key, chosen);
}

/// Keys with their default values pass, because a resolved scene contains every key.
void check_choices(const Scene& scene, const Plan& plan, const KeyProblems& report) {
    const Scene choices = with_choices(scene, plan);
    const Described asked{&scene_keys(), &scene}, chosen{&scene_keys(), &choices};
    for (const KeyTable::Part& part : scene_keys().parts) {
        if (part.is_list) continue;
        const void* values = part.one(const_cast<Scene*>(&scene));
        for (const Key& key : part.table->keys) {
            const std::string name = joined_path(part.name, key.name);
            if (key.selector.empty() || scene.places.count(name) == 0) continue;
            if (key.get(values).toml() == key.standard.toml() || !counts(key, asked, asked) || counts(key, chosen, chosen)) continue;
            const Key& decides = deciding_key(key, chosen);
            if (std::any_of(scene.panels.begin(), scene.panels.end(),
                            [&](const PanelKeys& panel) { return sets_one_of(panel.set, decides.selector, decides.selected_by); }))
                continue;
            std::string wanted;
            for (const std::string& one : decides.selected_by) wanted += (wanted.empty() ? "\"" : " or \"") + one + "\"";
            report(name,
                   fmt::format("{} belongs to {} = {}, and \"auto\" takes \"{}\" here", name, decides.selector, wanted,
                               selector_value(decides, chosen, chosen)),
                   fmt::format("remove it, or set {}", decides.selector));
        }
    }
}

void check_output(const Scene& scene, const KeyProblems& report) {
    if (!scene.output.chart.empty() && scene.panels.empty() && scene.places.count("output.chart") > 0)
        report("output.chart", "a chart needs panels, and this scene has none", "add a [[panel]]");
}

void check_forms(const Scene& scene, const Plan& plan, const KeyProblems& report) {
    const std::optional<PressureSource> source = plan.traits.pressure.source;
    if (source == PressureSource::velocity) {
        if (scene.pressure.correction)
            report("pressure.correction",
                   "pressure.correction is a share of the density error, which pressure.source = \"velocity\" does not correct",
                   "remove it, or use pressure.source = \"density\" or pressure.form = \"constraint\"");
        if (scene.pressure.damping != PressureOptions{}.damping)
            report("pressure.damping",
                   "pressure.damping acts on motion between neighbours, which pressure.source = \"velocity\" already removes",
                   "remove it, or use pressure.source = \"density\" or pressure.form = \"constraint\"");
        if (scene.models.shifting == ShiftingModel::fickian)
            report("models.shifting", "pressure.form = \"projection\" spreads its particles evenly itself: it does not use models.shifting",
                   "remove it, or use pressure.form = \"constraint\"", "allowed: auto or none");
    }
    const Preconditioner M = scene.pressure.preconditioner;
    if (source == PressureSource::density && (M == Preconditioner::none || M == Preconditioner::jacobi))
        for (const std::string key : {"pressure.cycle", "pressure.sweeps"})
            if (scene.places.count(key) > 0)
                report(key, fmt::format("{} is an option of the multigrid, and pressure.preconditioner is \"{}\"", key, name_of(M)),
                       "remove it, or use pressure.preconditioner = \"multigrid\"");
}

}  // namespace

void check_unused_keys(const Scene& scene, const Plan& plan, std::vector<Problem>& problems) {
    const KeyProblems report(scene, problems);
    check_choices(scene, plan, report);
    check_forms(scene, plan, report);
    check_output(scene, report);
}

}  // namespace whorl
