#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <regex>

#include "engine/scene/read.h"
#include "engine/scene/tree.h"

namespace whorl {
namespace {

class Writer {
public:
    explicit Writer(Described root) : root_(root) {}

    void table(const Described& here, const std::string& header, const std::string& path) {
        std::string lines;
        for (const Key& key : here.table->keys) {
            if (!counts(key, here, root_)) continue;
            const std::string line = key.name + " = " + key.get(here.object).toml();
            const std::string note = key.meaning + (key.unit.empty() ? "" : " [" + key.unit + "]");
            lines += fmt::format("{:<32} # {}\n", line, note);
        }
        // An entry of a list needs its header even if it has no keys.
        if (!header.empty() && (!lines.empty() || header[1] == '[')) text += "\n" + header + "\n";
        text += lines;
        each_part(here, path, [&](const KeyTable::Part& part, const std::string& name, const Described& inner) {
            const std::string bare = std::regex_replace(name, std::regex("\\[[0-9]+\\]"), "");
            table(inner, part.is_list ? "[[" + bare + "]]" : "[" + bare + "]", name);
        });
    }

    std::string text;

private:
    Described root_;
};

}  // namespace

std::string resolved_toml(const Scene& scene, const std::vector<Section>& sections) {
    const Described root{&scene_keys(), &scene};
    Writer writer(root);
    writer.text = "# Every value that was used. This file is a scene: rendering it repeats the run.\n";
    writer.table(root, "", "");
    for (const Section& s : sections) writer.table({s.table, s.object}, "[" + s.name + "]", s.name);
    return std::move(writer.text);
}

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
