#pragma once
/// Differences between two scenes, or between their plans. All comparisons of scenes use this file.
#include <optional>
#include <string>
#include <vector>

#include "engine/scene/plan.h"
#include "engine/scene/scene.h"
#include "engine/scene/tree.h"

namespace whorl {

/// A key that is used in a scene, with its value.
struct UsedKey : KeyValue {
    const Key* key = nullptr;
    bool decides = true;  ///< the simulation's result depends on it
};
/// Appends the keys of a section that are in use, in the order of its table. @param name of the section in the file, "" for the scene
/// itself
/// @param scene the scene in which selectors like "models.pressure" are looked up
void add_used_keys(const Described& section, const Described& scene, const std::string& name, std::vector<UsedKey>& all);

/// A key with different values. `before` or `now` is empty if only one side has the key.
struct KeyDifference {
    std::string path;
    std::optional<Value> before, now;
    const Key* key = nullptr;
    /// "fluid.viscosity: 1000.0, now 500.0"
    std::string text() const;
};
/// The differences in the order of `now`; keys that `now` lacks are last.
std::vector<KeyDifference> differences(const std::vector<UsedKey>& before, const std::vector<UsedKey>& now);

/// Differences of the settings that affect the simulation (not drawing, names, probes or files), one line each. Empty: a run of one scene
/// can continue as the other.
std::vector<std::string> differences(const Scene& before, const Scene& now);

/// Differences between two plans in choices that cannot change during a run.
std::vector<KeyDifference> changes_of_models(const Plan& running, const Plan& wanted);

}  // namespace whorl
