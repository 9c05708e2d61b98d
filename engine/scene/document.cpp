#include "engine/scene/document.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>

namespace whorl {
namespace {

FileLocation place_of(const toml::source_region& at, const std::string& file) {
    return {file, static_cast<int>(at.begin.line), static_cast<int>(at.begin.column)};
}

constexpr std::size_t most_nested = 500;  ///< most dots in a line, which separate the parts of keys

/// Refuses deeply nested keys: toml++ and the readers of its tables recurse for every part of a dotted key, so ten thousand parts would
/// overflow the stack. @throws InputError if a line has more dots than any line of a scene
void check_nesting(const std::string& text, const std::string& file) {
    std::istringstream lines(text);
    int number = 0;
    for (std::string line; std::getline(lines, line);)
        if (++number; static_cast<std::size_t>(std::count(line.begin(), line.end(), '.')) > most_nested)
            throw InputError({file, number, 1}, fmt::format("a line of more than {} dots", most_nested), "",
                             "allowed: keys of up to four parts");
}

Value converted(const toml::node& node, const std::string& file) {
    Value v;
    if (const auto* table = node.as_table()) {
        Value::Table entries;
        for (const auto& [key, child] : *table) {
            entries.emplace_back(std::string(key.str()), converted(child, file));
            entries.back().second.key_place = place_of(key.source(), file);
        }
        const auto earlier = [](const auto& a, const auto& b) {
            const FileLocation &p = a.second.key_place, &q = b.second.key_place;
            return std::pair(p.line, p.column) < std::pair(q.line, q.column);
        };
        std::stable_sort(entries.begin(), entries.end(), earlier);
        v = Value(std::move(entries));
    } else if (const auto* array = node.as_array()) {
        Value::List list;
        for (const toml::node& child : *array) list.push_back(converted(child, file));
        v = Value(std::move(list));
    } else if (const auto* text = node.as_string()) {
        v = Value(text->get());
    } else if (const auto* whole = node.as_integer()) {
        v = Value(whole->get());
    } else if (const auto* number = node.as_floating_point()) {
        v = Value(number->get());
    } else if (const auto* flag = node.as_boolean()) {
        v = Value(flag->get());
    }
    v.place = place_of(node.source(), file);
    v.key_place = v.place;
    return v;
}

/// The message of toml++ without "Error while parsing array: ...".
std::string message_of(const toml::parse_error& e) {
    std::string text(e.description());
    const std::string start = "Error while parsing ";
    if (text.rfind(start, 0) == 0) text = "in this " + text.substr(start.size());
    else if (!text.empty()) text[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(text[0])));
    return text;
}

bool is_index(const std::string& step) {
    return !step.empty() && step.size() < 7 && std::all_of(step.begin(), step.end(), [](unsigned char c) { return std::isdigit(c); });
}

/// Splits a key: "emitter[0].speed" and "emitter.0.speed" give emitter, 0, speed. Empty if it is not a key.
std::vector<std::string> steps_of(const std::string& key) {
    std::vector<std::string> steps;
    std::string part;
    std::istringstream in(key);
    if (key.empty() || key.back() == '.') return {};
    while (std::getline(in, part, '.')) {
        const std::size_t bracket = part.find('[');
        steps.push_back(part.substr(0, bracket));
        if (steps.back().empty() || steps.back().find_first_of(" \t\"'=") != std::string::npos) return {};
        for (std::size_t at = bracket; at < part.size();) {
            const std::size_t close = part.find(']', at);
            if (part[at] != '[' || close == std::string::npos) return {};
            steps.push_back(part.substr(at + 1, close - at - 1));
            if (!is_index(steps.back())) return {};
            at = close + 1;
        }
        if (steps.size() > most_nested) return {};
    }
    return steps;
}

std::string joined(const std::vector<std::string>& steps, std::size_t count) {
    std::string path;
    for (std::size_t i = 0; i < count; ++i) path += is_index(steps[i]) ? "[" + steps[i] + "]" : (i > 0 ? "." : "") + steps[i];
    return path;
}

/// Sets `value` at the path below `node`. Creates missing tables, and the next entry of a list.
void put(Value& node, const std::vector<std::string>& steps, std::size_t depth, const Value& value, std::vector<Problem>& problems) {
    if (depth == steps.size()) {
        node = value;
        return;
    }
    const std::string& step = steps[depth];
    if (auto* list = node.as<Value::List>()) {
        const std::size_t index = is_index(step) ? std::stoul(step) : list->size() + 1;
        if (index > list->size()) {
            const std::string path = joined(steps, depth);
            const std::string wanted =
                is_index(step) ? "missing entry " + joined(steps, depth + 1) : path + " is a list, which has no " + step;
            const std::string key = list->empty() || list->front().as<Value::Table>() ? "." + step : "";
            problems.push_back({value.place, wanted, is_index(step) ? "" : "name an entry, as in " + path + "[0]" + key,
                                list->empty() ? "" : path + " has the entries 0 to " + std::to_string(list->size() - 1)});
            return;
        }
        if (index == list->size()) list->push_back(placed(Value(Value::Table{}), value.place));
        return put((*list)[index], steps, depth + 1, value, problems);
    }
    // A plain value that is not a table: the change replaces it.
    if (!node.as<Value::Table>()) node = placed(Value(Value::Table{}), value.place);
    if (Value* child = node.find(step)) return put(*child, steps, depth + 1, value, problems);
    // A list that does not exist yet starts with entry 0.
    Value child = depth + 1 < steps.size() && is_index(steps[depth + 1]) ? Value(Value::List{}) : Value(Value::Table{});
    child = placed(std::move(child), value.key_place);
    put(child, steps, depth + 1, value, problems);
    node.as<Value::Table>()->emplace_back(step, std::move(child));
}

/// How to write values that are often written wrong. @param what message of toml++
std::string syntax_hint(const std::string& what) {
    const auto says = [&](const char* part) { return what.find(part) != std::string::npos; };
    if (says("utf-8")) return "save the file as UTF-8";
    if (says("string")) return "add the closing quote";
    if (says("table header") || says("redefine") || says("expected '='")) return "";
    return "write numbers as in 0.5 or 1e-3, without a unit; put strings and expressions in quotes; booleans are true and false";
}

}  // namespace

Value parse_toml(const std::string& text, const std::string& file) {
    check_nesting(text, file);
    try {
        return converted(toml::parse(text, file), file);
    } catch (const toml::parse_error& e) {
        const std::string what = message_of(e);
        throw InputError(place_of(e.source(), file), "not TOML: " + what, syntax_hint(what));
    }
}

Value parse_toml_file(const std::string& file) {
    std::ifstream in(file, std::ios::binary);
    std::ostringstream text;
    if (!in || std::filesystem::is_directory(file) || !(text << in.rdbuf()))
        throw InputError({file, 0, 0}, std::filesystem::is_directory(file) ? "is a folder, not a scene file"
                                       : std::filesystem::exists(file)     ? "cannot be read, or is empty"
                                                                           : "no such file");
    return parse_toml(text.str(), file);
}

Value placed(Value v, const FileLocation& place) {
    v.place = v.key_place = place;
    if (auto* list = v.as<Value::List>())
        for (Value& child : *list) child = placed(std::move(child), place);
    if (auto* table = v.as<Value::Table>())
        for (auto& [key, child] : *table) child = placed(std::move(child), place);
    return v;
}

Value parse_value(const std::string& text, const std::string& source) {
    const FileLocation place{source, 0, 0};
    check_nesting(text, source);
    try {
        return placed(*converted(toml::parse("value = " + text), "").find("value"), place);
    } catch (const toml::parse_error& e) {
        // A value that begins like TOML must be TOML. Others are numbers (.5 and 1e999) or unquoted texts, as in models.pressure=ppe.
        if (text.find_first_of("[{\"'") == 0)
            throw InputError(place, "the value is not TOML: " + message_of(e), syntax_hint(message_of(e)));
        char* end = nullptr;
        const double number = std::strtod(text.c_str(), &end);
        return placed(*end == 0 ? Value(number) : Value(text), place);
    }
}

std::string full_path(const std::string& path) {
    const std::vector<std::string> steps = steps_of(path);
    return steps.empty() ? path : joined(steps, steps.size());
}

KeyValue parse_change(const std::string& text, const std::string& option) {
    const auto trimmed = [](const std::string& part) {
        const std::size_t begin = std::min(part.find_first_not_of(" \t"), part.size());
        return part.substr(begin, part.find_last_not_of(" \t") + 1 - begin);
    };
    const std::size_t equals = std::min(text.find('='), text.size());
    const std::string key = trimmed(text.substr(0, equals)), value = trimmed(text.substr(std::min(equals + 1, text.size())));
    if (value.empty())
        throw InputError({option + " " + text, 0, 0}, "the change has no value", "", "allowed: key=value, as in fluid.viscosity=100");
    return {key, parse_value(value, option + " " + text)};
}

void set_key(Value& root, const KeyValue& change, std::vector<Problem>& problems) {
    const std::vector<std::string> steps = steps_of(change.path);
    if (!steps.empty()) return put(root, steps, 0, change.value, problems);
    problems.push_back(
        {change.value.place, "\"" + change.path + "\" is not a key", "", "allowed: names with dots between them, as in emitter[0].speed"});
}

void overlay(Value& root, const Value& table, const std::string& path, std::vector<Problem>& problems) {
    for (const auto& [key, value] : *table.as<Value::Table>()) {
        const std::string full = path.empty() ? key : path + "." + key;
        if (value.as<Value::Table>()) {
            overlay(root, value, full, problems);
        } else {
            set_key(root, {full, value}, problems);
        }
    }
}

}  // namespace whorl
