#pragma once
/// Plans of one scene with some keys changed: honey poured onto a plate.
#include <string>
#include <vector>

#include "engine/scene/plan.h"

namespace whorl::test {

extern const std::string poured_honey;

Scene scene_with(const std::vector<std::string>& changes, const std::string& text = poured_honey);
Plan plan_with(const std::vector<std::string>& changes);
/// The plan's choice for a key. @throws std::logic_error if it has no choice
const Choice& choice(const Plan& plan, const std::string& key);
/// The messages if the scene is refused, else "no error".
std::string messages_with(const std::vector<std::string>& changes, const std::string& text = poured_honey);
/// Number of the plan's warnings that contain `part`.
int warnings_with(const Plan& plan, const std::string& part);

}  // namespace whorl::test
