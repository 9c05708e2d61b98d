#pragma once
/// Differences between two scenes, or between their plans. All comparisons of scenes use this one.
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/scene/plan.h"
#include "engine/scene/scene.h"
#include "engine/scene/tree.h"

namespace whorl {

/// A key that counts in a scene, by its full name: "emitter[0].speed".
struct UsedKey {
    std::string path;
    const Key* key;
    const void* object;
    bool decides;  ///< the simulation's result depends on it
    Value value() const { return key->get(object); }
};
/// Appends the keys of a section that count, in the order of its table. @param name of the section in the file, "" for the scene itself
/// @param scene where keys of the section find the models that they belong to
void add_used_keys(const Described& section, const Described& scene, const std::string& name, std::vector<UsedKey>& all);

/// Values by their names, as a scene file writes them: {"fluid.viscosity", "1000.0"}.
using NamedTexts = std::vector<std::pair<std::string, std::string>>;

struct Difference {
    std::string name;
    std::optional<std::string> before, now;  ///< nothing if there is no such value
    /// "fluid.viscosity: 1000.0, now 500.0"
    std::string text() const;
};
/// Differences in the order of `now`; removed keys are last.
std::vector<Difference> differences(const NamedTexts& before, const NamedTexts& now);
std::vector<std::string> texts_of(const std::vector<Difference>& differences);

/// Differences of the settings that affect the simulation (not drawing, names, probes or files). Empty: a run of one scene
/// can continue as the other.
std::vector<std::string> differences(const Scene& before, const Scene& now);

/// A line each: "models.viscosity: none, now full".
std::vector<std::string> changes_of_models(const Plan& running, const Plan& wanted);

}  // namespace whorl
