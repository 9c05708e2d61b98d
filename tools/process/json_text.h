#pragma once
#include <nlohmann/json.hpp>
#include <string>

namespace whorl {

/// Text of a JSON value. Bytes that are not valid UTF-8, which names of folders may contain, become U+FFFD.
inline std::string json_text(const nlohmann::ordered_json& json, int indent = -1) {
    return json.dump(indent, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace whorl
