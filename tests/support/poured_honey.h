#pragma once
/// Plans of one scene with some keys changed: honey poured onto a plate.
#include <string>
#include <vector>

#include "engine/scene/plan.h"

namespace whorl::test {

extern const std::string poured_honey;

Scene scene_with(const std::vector<std::string>& changes, const std::string& text = poured_honey);
Plan plan_with(const std::vector<std::string>& changes);
/// What the plan chose for a key. @throws std::logic_error where it chose nothing
const Choice& choice(const Plan& plan, const std::string& key);
/// What is said of the scene where it is refused, else "no error".
std::string messages_with(const std::vector<std::string>& changes);

}  // namespace whorl::test
