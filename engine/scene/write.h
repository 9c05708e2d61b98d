#pragma once
/// A scene as text.
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "engine/core/keys.h"
#include "engine/scene/read.h"

namespace whorl {

/// Every value used, as a scene file that reads back as the same scene.
std::string resolved_toml(const Scene& scene, const std::vector<Section>& sections = {});

nlohmann::ordered_json json_of(const Value& value);

}  // namespace whorl
