#pragma once
/// A key's value as JSON.
#include <nlohmann/json_fwd.hpp>

#include "engine/core/keys.h"

namespace whorl {

nlohmann::ordered_json json_of(const Value& value);

}  // namespace whorl
