#pragma once
/// Conversion between values of scene keys and JSON.
#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "engine/scene/read.h"
#include "tools/scene_file/scene_changes.h"

namespace whorl {

/// Converts JSON to a value. Empty for values that no key accepts: null, objects, nested lists, lists of more than 100 entries, texts of
/// more than 1000 bytes.
std::optional<Value> value_of(const nlohmann::json& json);

/// Values of the keys that may change during a run: {"fluid.viscosity": 1000.0, ...}.
nlohmann::ordered_json live_values(const SceneFile& file);
/// Descriptions of the keys for the page: path, unit, meaning, type, range, choices, value, and whether the key may change during a run.
nlohmann::ordered_json described_keys(const SceneFile& file);

/// Changes of the scene from {"fluid.viscosity": 500, ...}. @throws InputError if it is not an object, or has a value of an unknown type
std::vector<KeyValue> changes_of(const nlohmann::json& json, const SceneFile& file);

}  // namespace whorl
