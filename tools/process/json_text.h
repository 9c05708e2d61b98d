#pragma once
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

namespace whorl {

/// Text of a JSON value. Bytes that are not valid UTF-8, which names of folders may contain, become U+FFFD.
inline std::string json_text(const nlohmann::ordered_json& json, int indent = -1) {
    return json.dump(indent, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

/// Content of a JSON file; a discarded value if the file is missing or invalid.
inline nlohmann::json json_of(const std::filesystem::path& file) {
    std::ifstream in(file);
    return nlohmann::json::parse(in, nullptr, false);
}

}  // namespace whorl
