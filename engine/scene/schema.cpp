#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "engine/core/keys.h"
#include "engine/scene/read.h"

namespace whorl {
namespace {

using Json = nlohmann::ordered_json;

Json bounded(const Key& key, Json type) {
    if (std::isfinite(key.least) && std::abs(key.least) < 2e9) type[key.least_open ? "exclusiveMinimum" : "minimum"] = key.least;
    if (std::isfinite(key.most) && std::abs(key.most) < 2e9) type["maximum"] = key.most;
    return type;
}

Json choice_of(const Key& key) {
    Json type = {{"type", "string"}};
    if (key.choices.empty()) return type;
    type["enum"] = key.choices;
    if (key.may_be_auto) type["enum"].push_back("auto");
    return type;
}

Json schema_of(const Key& key) {
    Json s;
    switch (key.type) {
        case KeyType::flag: s = {{"type", "boolean"}}; break;
        case KeyType::integer: s = bounded(key, {{"type", "integer"}}); break;
        case KeyType::number: s = bounded(key, {{"type", "number"}}); break;
        case KeyType::text: s = choice_of(key); break;
        case KeyType::expression: s = {{"anyOf", {bounded(key, {{"type", "number"}}), {{"type", "string"}}}}}; break;
        case KeyType::any: s = Json::object(); break;
    }
    if (key.is_list) {
        s = {{"type", "array"}, {"items", std::move(s)}};
        if (key.count > 0) s["minItems"] = key.may_lack_depth() ? 2 : key.count, s["maxItems"] = key.count;
    }
    if (key.access->from_text) s = {{"anyOf", {s, {{"type", "string"}}}}};
    if (key.may_be_auto && (key.is_list || key.choices.empty())) s = {{"anyOf", {s, {{"const", "auto"}}}}};
    s["description"] = key.meaning + (key.unit.empty() ? "" : " [" + key.unit + "]");
    if (!key.is_required) s["default"] = json_of(key.standard);
    return s;
}

/// @param partial whether all keys are optional, as in a [quality] table
Json schema_of(const KeyTable& table, bool partial) {
    Json s = {{"type", "object"}, {"description", table.meaning}, {"additionalProperties", false}, {"properties", Json::object()}};
    Json required = Json::array();
    for (const Key& key : table.keys) {
        s["properties"][key.name] = schema_of(key);
        if (key.is_required && key.selector.empty()) required.push_back(key.name);
    }
    for (const KeyTable::Part& part : table.parts) {
        Json inner = schema_of(*part.table, partial);
        if (part.is_list) {
            // A quality may change entry 0, 1, ... of a list, as in emitter.0.speed.
            const Json entries = {{"type", "array"}, {"items", schema_of(*part.table, false)}};
            inner =
                partial
                    ? Json{{"anyOf",
                            {entries, {{"type", "object"}, {"patternProperties", {{"^[0-9]+$", inner}}}, {"additionalProperties", false}}}}}
                    : entries;
        } else if (inner.contains("required") && !partial) {
            required.push_back(part.name);
        }
        s["properties"][part.name] = std::move(inner);
    }
    if (!required.empty() && !partial) s["required"] = std::move(required);
    return s;
}

Json whole_schema(const std::vector<Section>& sections, bool partial) {
    Json s = schema_of(scene_keys(), partial);
    for (const Section& section : sections) s["properties"][section.name] = schema_of(*section.table, partial);
    return s;
}

std::string in_code(const std::string& text) { return "`" + text + "`"; }

void markdown(const KeyTable& table, const std::string& header, const std::string& path, std::string& text) {
    text += "\n## " + (header.empty() ? "At the top" : in_code(header)) + "\n\n" + table.meaning + "\n\n";
    if (!table.keys.empty()) text += "| key | unit | default | allowed | meaning |\n|---|---|---|---|---|\n";
    for (const Key& key : table.keys) {
        std::string allowed = key.allowed();
        if (allowed.empty() || key.type == KeyType::expression || key.count > 0)
            allowed = key.type_name() + (allowed.empty() ? "" : ", " + allowed);
        if (!key.variables.empty()) allowed += " of " + variable_names(key.variables);
        std::string meaning = key.meaning;
        if (!key.selector.empty()) meaning += fmt::format(" (only with {} = {})", key.selector, fmt::join(key.selected_by, ", "));
        const std::string standard = key.is_required ? "required" : in_code(key.standard.toml());
        text += "| " + in_code(key.name) + " | " + key.unit + " | " + standard + " | " + allowed + " | " + meaning + " |\n";
    }
    for (const KeyTable::Part& part : table.parts) {
        const std::string name = path.empty() ? part.name : path + "." + part.name;
        markdown(*part.table, part.is_list ? "[[" + name + "]]" : "[" + name + "]", name, text);
    }
}

}  // namespace

std::string json_schema(const std::vector<Section>& sections) {
    Json s = {{"$schema", "http://json-schema.org/draft-07/schema#"}, {"title", "Whorl scene"}};
    s.update(whole_schema(sections, false));
    const Json partial = whole_schema(sections, true);
    s["definitions"]["changes"] = partial;
    const Json changes = {{"$ref", "#/definitions/changes"}};
    s["properties"]["quality"] = {{"type", "object"},
                                  {"description", "changes of the scene with --quality draft or --quality fine"},
                                  {"additionalProperties", false},
                                  {"properties", {{"draft", changes}, {"fine", changes}}}};
    return s.dump(2) + "\n";
}

std::string markdown_reference(const std::vector<Section>& sections) {
    std::string text =
        "# Keys of a scene file\n\nWritten by `whorl schema --markdown`; do not edit by hand. Scene files are TOML with SI units. Unknown "
        "keys are errors.\nAn expression is a text such as `\"0.25 + 0.1*sin(2*pi*t)\"`, with t [s], x, y, z [m], pi and the functions of "
        "muParser.\n`[quality.draft]` and `[quality.fine]` may contain any of these keys (`fluid.spacing = 3e-3`, `emitter.0.speed = "
        "0.2`): `--quality draft`\napplies its table to the file. The file itself is the standard quality. `--set key=value` overrides "
        "both.\n";
    markdown(scene_keys(), "", "", text);
    for (const Section& section : sections) markdown(*section.table, "[" + section.name + "]", section.name, text);
    return text;
}

}  // namespace whorl
