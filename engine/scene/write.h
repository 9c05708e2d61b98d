#pragma once
/// A scene as text.
#include <string>
#include <vector>

#include "engine/scene/read.h"

namespace whorl {

/// Every value used, as a scene file that reads back as the same scene.
std::string resolved_toml(const Scene& scene, const std::vector<Section>& sections = {});

}  // namespace whorl
