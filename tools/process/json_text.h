#pragma once
#include <nlohmann/json.hpp>
#include <string>

namespace whorl {

/// A value as JSON. Bytes that are no UTF-8, as names of folders may have, become U+FFFD.
inline std::string json_text(const nlohmann::ordered_json& json, int indent = -1) {
    return json.dump(indent, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace whorl
