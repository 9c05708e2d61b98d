#pragma once
/// A scene as text: every value used, and what differs between two scenes.
#include <string>
#include <vector>

#include "engine/scene/read.h"

namespace whorl {

/// Every value used, as a scene file that reads back as the same scene.
std::string resolved_toml(const Scene& scene, const std::vector<Section>& sections = {});

/// The settings that decide what a simulation does (not what is drawn, named, probed or written), one "key = value" a line.
std::string deciding_settings(const Scene& scene);
/// What differs between those of two scenes, one line each: "fluid.viscosity: 1000.0, now 500.0". Empty: a run of one can go on as the
/// other.
std::vector<std::string> differences(const Scene& before, const Scene& now);

}  // namespace whorl
