#include "engine/scene/value_json.h"

#include <nlohmann/json.hpp>

namespace whorl {

nlohmann::ordered_json json_of(const Value& v) {
    if (const bool* flag = v.as<bool>()) return *flag;
    if (const auto* whole = v.as<std::int64_t>()) return *whole;
    if (const double* number = v.as<double>()) return *number;
    if (const std::string* text = v.as<std::string>()) return *text;
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    if (const auto* values = v.as<Value::List>())
        for (const Value& e : *values) list.push_back(json_of(e));
    return list;
}

}  // namespace whorl
