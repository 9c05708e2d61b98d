#include "engine/scene/as_printed.h"

#include "engine/scene/checks.h"
#include "engine/scene/names.h"
#include "engine/scene/read.h"
#include "engine/scene/tree.h"

namespace whorl {
namespace {

struct PrintedValue {
    const char *part, *key;
    Value value;
};

const std::vector<PrintedValue>& printed_values() {
    const auto text = [](const char* word) { return Value(std::string(word)); };
    static const std::vector<PrintedValue> all{
        {"models", "shifting", text("none")},           {"pressure", "form", text("projection")},
        {"pressure", "source", text("density")},        {"pressure", "preconditioner", text("multigrid")},
        {"pressure", "cycle", text("v_cycle")},         {"pressure", "clamp", Value(true)},
        {"pressure", "correction", Value(1.0)},         {"pressure", "damping", Value(0.0)},
        {"pressure", "sound_damping", Value(0.0)},      {"pressure", "artificial_viscosity", Value(0.0)},
        {"boundary", "volume_factor", Value(1.0)},      {"viscosity", "penalty", Value(0.0)},
        {"micropolar", "micro_inertia", Value(2.0)},    {"micropolar", "spin_length", Value(1.0)},  // gamma = mu
        {"micropolar", "spin_viscosity", text("auto")}, {"micropolar", "co_rotating", Value(false)},
        {"micropolar", "xsph_velocity", Value(0.002)},  {"micropolar", "xsph_spin", Value(0.125)},
        {"micropolar", "xsph_time", Value(0.0)},
    };
    return all;
}

}  // namespace

Scene as_printed(const Scene& scene) {
    Scene printed = scene;
    if (!scene.models.printed()) return printed;
    for (const PrintedValue& one : printed_values()) {
        const KeyTable::Part* part = scene_keys().find_part(one.part);
        std::vector<Problem> none;
        part->table->find_key(one.key)->read(part->one(&printed), one.value, one.key, none);
    }
    if (!scene.viscosity.laplacian) printed.viscosity.laplacian = LaplacianForm::brookshaw;
    if (traits_of(scene.models.micropolar).spins && scene.models.pressure == PressureModel::automatic)
        printed.models.pressure = PressureModel::wcsph;
    return printed;
}

void check_printed(const Scene& scene, const Plan& plan, std::vector<Problem>& problems) {
    if (!scene.models.printed()) return;
    const KeyProblems report(scene, problems);
    // Keys with their default values pass, because a resolved scene contains every key.
    for (const PrintedValue& one : printed_values()) {
        const KeyTable::Part* part = scene_keys().find_part(one.part);
        const Key& key = *part->table->find_key(one.key);
        const std::string name = joined_path(one.part, one.key), found = key.get(part->one(const_cast<Scene*>(&scene))).toml();
        if (found != key.standard.toml() && found != one.value.toml())
            report(name, name + " = " + found + " is not what the notes print, " + one.value.toml(), "remove it, or models.notes");
    }
    const auto refuse = [&](const char* key, const std::string& what, const char* remedy) {
        report(key, what + " is not in the notes, and models.notes = \"as_printed\"", remedy);
    };
    if (plan.traits.pressure.solves && plan.traits.pressure.source != PressureSource::density)
        refuse("models.pressure", "models.pressure = " + described(plan.traits.pressure), "use \"ppe\" or \"wcsph\"");
    if (plan.viscosity == ViscosityModel::full)
        refuse("models.viscosity", "the matrix-free models.viscosity = \"full\", whose gradients have the volume V_i,",
               "use \"full_assembled\", or \"explicit\"");
    if (plan.traits.micropolar.spins && plan.micropolar != MicropolarModel::notes)
        refuse("models.micropolar", std::string("models.micropolar = \"") + name_of(plan.micropolar) + "\"", "use \"notes\"");
    if (scene.viscosity.laplacian == LaplacianForm::split)
        refuse("viscosity.laplacian", "viscosity.laplacian = \"split\"", "use \"brookshaw\" or \"monaghan\"");
}

}  // namespace whorl
