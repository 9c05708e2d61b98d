#pragma once
/// Values of scene keys as JSON, and back.
#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "engine/scene/read.h"
#include "tools/scene_file/scene_changes.h"

namespace whorl {

/// Nothing where no key takes such a value: null, objects, lists in lists, long texts.
std::optional<Value> value_of(const nlohmann::json& json);

/// {"fluid.viscosity": 1000.0, ...} of the keys that may change during a run.
nlohmann::ordered_json live_values(const SceneFile& file);
/// Data for showing each key on a page: path, unit, meaning, type, range, choices, whether it may change during a run.
nlohmann::ordered_json described_keys(const SceneFile& file);

/// Changes of the scene from {"fluid.viscosity": 500, ...}. @throws InputError if it is not an object, or has a value of an unknown type
std::vector<KeyValue> changes_of(const nlohmann::json& json, const SceneFile& file);

}  // namespace whorl
