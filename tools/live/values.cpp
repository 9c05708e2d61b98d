#include "tools/live/values.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "engine/core/keys.h"

namespace whorl {
namespace {

using Json = nlohmann::ordered_json;

/// Limits of a request's values, above those of any real scene: bytes of a text, entries of a list.
constexpr std::size_t longest_text = 1000, longest_list = 100;

std::string type_of(const Key& key) {
    if (key.type == KeyType::text && !key.is_list && !key.choices.empty()) return "choice";
    static const std::map<KeyType, std::string> names{
        {KeyType::flag, "flag"}, {KeyType::integer, "integer"},       {KeyType::number, "number"},
        {KeyType::text, "text"}, {KeyType::expression, "expression"}, {KeyType::any, "any"}};
    return names.at(key.type) + (key.is_list ? "s" : "");
}

/// A key's bound as JSON; null for limits of the C++ type, which are no use to users.
Json bound(double v) { return std::isfinite(v) && std::abs(v) < 2e9 ? Json(v) : Json(); }

/// Whether the page does not show a key: names, files, output.
bool hidden(const UsedKey& k) {
    for (const char* part : {"output.", "probe[", "camera.key"})
        if (k.path.rfind(part, 0) == 0 || k.path.find("].key[") != std::string::npos) return true;
    return k.path == "name" || k.path == "seed" || (type_of(*k.key) == "text" && !k.key->may_change);
}

bool accepts_text(const std::vector<UsedKey>& keys, const std::string& path) {
    return std::any_of(keys.begin(), keys.end(),
                       [&](const UsedKey& k) { return k.path == path && k.key->type == KeyType::text && type_of(*k.key) != "choice"; });
}

/// Converts texts that are numbers to numbers, as the command line does.
Value with_numbers(Value value) {
    if (auto* list = value.as<Value::List>())
        for (Value& entry : *list) entry = with_numbers(std::move(entry));
    const auto* text = value.as<std::string>();
    if (!text || text->empty() || text->size() > 40 || text->find_first_not_of("+-._0123456789eE") != std::string::npos) return value;
    Value number = parse_value(*text);
    return number.is_number() ? number : value;
}

}  // namespace

std::optional<Value> value_of(const nlohmann::json& json) {
    if (json.is_boolean()) return Value(json.get<bool>());
    if (json.is_number_unsigned() && json.get<std::uint64_t>() > std::uint64_t(std::numeric_limits<std::int64_t>::max()))
        return Value(json.get<double>());
    if (json.is_number_integer()) return Value(json.get<std::int64_t>());
    if (json.is_number()) return Value(json.get<double>());
    if (json.is_string()) {
        auto text = json.get<std::string>();
        if (text.size() > longest_text) return std::nullopt;
        return Value(std::move(text));
    }
    if (!json.is_array() || json.size() > longest_list) return std::nullopt;
    Value::List list;
    for (const auto& entry : json) {
        if (entry.is_array()) return std::nullopt;
        auto value = value_of(entry);
        if (!value) return std::nullopt;
        list.push_back(std::move(*value));
    }
    return Value(std::move(list));
}

Json live_values(const SceneFile& file) {
    Json all = Json::object();
    for (const UsedKey& k : used_keys(file))
        if (k.key->may_change) all[k.path] = json_of(k.value);
    return all;
}

Json described_keys(const SceneFile& file) {
    Json all = Json::array();
    for (const UsedKey& k : used_keys(file)) {
        if (hidden(k)) continue;
        const Key& key = *k.key;
        all.push_back({{"path", k.path},
                       {"unit", key.unit},
                       {"meaning", key.meaning},
                       {"type", type_of(key)},
                       {"count", key.count},
                       {"least", bound(key.least)},
                       {"least_open", key.least_open},
                       {"most", bound(key.most)},
                       {"choices", key.choices},
                       {"auto", key.may_be_auto},
                       {"variables", variable_names(key.variables)},
                       {"live", key.may_change},
                       {"value", json_of(k.value)}});
    }
    return all;
}

std::vector<KeyValue> changes_of(const nlohmann::json& json, const SceneFile& file) {
    const std::string form = "allowed: an object of keys and values, as in {\"fluid.viscosity\": 500}";
    if (!json.is_object()) throw InputError({}, "the changes are not a JSON object", "", form);
    const std::vector<UsedKey> keys = used_keys(file);
    std::vector<KeyValue> changes;
    std::vector<Problem> problems;
    for (const auto& [path, entry] : json.items()) {
        auto value = value_of(entry);
        const std::string full = full_path(path);
        if (value && !accepts_text(keys, full)) value = with_numbers(std::move(*value));
        if (value) changes.push_back({full, std::move(*value)});
        else problems.push_back({{}, path.substr(0, 100) + " has a value that no key accepts", "", form});
    }
    if (!problems.empty()) throw InputError(std::move(problems));
    return changes;
}

}  // namespace whorl
