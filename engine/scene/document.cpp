#include "engine/scene/document.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <regex>
#include <sstream>

namespace whorl {
namespace {

Place place_of(const toml::source_region& at, const std::string& file) {
    return {file, static_cast<int>(at.begin.line), static_cast<int>(at.begin.column)};
}

constexpr int most_nested = 100;  ///< parts of a key

/// End of the quoted text that begins there. One in single marks ends at the latest with its line.
std::size_t end_of_quoted(const std::string& text, std::size_t begin) {
    const char mark = text[begin];
    const bool over_lines = text.compare(begin, 3, std::string(3, mark)) == 0;
    const std::string marks(over_lines ? 3 : 1, mark);
    for (std::size_t i = begin + marks.size(); i < text.size(); ++i) {
        if (mark == '"' && text[i] == '\\') ++i;
        else if (!over_lines && text[i] == '\n') return i;
        else if (text.compare(i, marks.size(), marks) == 0) {
            i += marks.size();
            for (int n = 0; over_lines && n < 2 && i < text.size() && text[i] == mark; ++n) ++i;  // its last characters may be marks, too
            return i;
        }
    }
    return text.size();
}

/// toml++ and the readers of its tables recurse for every part of a dotted key: ten thousands of parts overflow the stack. A quoted
/// text is one part, whatever is in it; comments are skipped.
/// @throws InputError if a key has more parts than any key of a scene
void check_nesting(const std::string& text, const std::string& file) {
    int dots = 0;
    char last = 0;  // that is no blank
    bool blank = false;
    for (std::size_t i = 0, next = 0; i < text.size(); i = next) {
        const char c = text[i];
        const bool quoted = c == '"' || c == '\'';
        next = quoted ? end_of_quoted(text, i) : c == '#' ? std::min(text.find('\n', i), text.size()) : i + 1;
        if (c == ' ' || c == '\t') {
            blank = true;
            continue;
        }
        const bool in_part = quoted || std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-';
        if (c == '.' && ++dots > most_nested) {
            const auto line = static_cast<int>(std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(i), '\n'));
            const auto column = static_cast<int>(i - (line > 0 ? text.rfind('\n', i) : std::string::npos));
            throw InputError({file, line + 1, column}, fmt::format("a key of more than {} parts", most_nested), "", "allowed: up to four");
        }
        if (c != '.' && (!in_part || (blank && last != '.'))) dots = 0;
        last = c, blank = false;
    }
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
            const Place &p = a.second.key_place, &q = b.second.key_place;
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

/// toml++ says "Error while parsing array: expected ...".
std::string message_of(const toml::parse_error& e) {
    std::string text(e.description());
    const std::string start = "Error while parsing ";
    if (text.rfind(start, 0) == 0) text = "in this " + text.substr(start.size());
    else if (!text.empty()) text[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(text[0])));
    return text;
}

struct Step {
    std::string name;
    bool is_index = false;
    std::size_t index = 0;
};

bool digits(const std::string& text) {
    return !text.empty() && text.size() < 7 && std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isdigit(c); });
}

/// "emitter[0].speed" -> emitter, 0, speed; empty if it is not a key.
std::vector<Step> parse_path(const std::string& key) {
    std::vector<Step> steps;
    std::string part;
    std::istringstream in(key);
    if (key.empty() || key.back() == '.') return {};
    while (std::getline(in, part, '.')) {
        const std::size_t bracket = part.find('[');
        const std::string name = part.substr(0, bracket);
        if (name.empty() || name.find_first_of(" \t\"'=") != std::string::npos) return {};
        steps.push_back({name, digits(name), digits(name) ? std::stoul(name) : 0});
        for (std::size_t at = bracket; at != std::string::npos && at < part.size();) {
            const std::size_t close = part.find(']', at);
            if (part[at] != '[' || close == std::string::npos) return {};
            const std::string index = part.substr(at + 1, close - at - 1);
            if (!digits(index)) return {};
            steps.push_back({index, true, std::stoul(index)});
            at = close + 1;
        }
        if (steps.size() > most_nested) return {};
    }
    return steps;
}

/// Puts `value` at the path below `node`, making tables and the next entry of a list on the way.
void put(Value& node, const std::vector<Step>& steps, std::size_t depth, const Value& value, std::vector<Problem>& problems) {
    if (depth == steps.size()) {
        node = value;
        return;
    }
    const Step& step = steps[depth];
    if (auto* list = node.as<Value::List>()) {
        if (!step.is_index || step.index > list->size()) {
            std::string path = steps[0].name;
            for (std::size_t i = 1; i < depth; ++i) path += steps[i].is_index ? "[" + steps[i].name + "]" : "." + steps[i].name;
            const std::string wanted =
                step.is_index ? "missing entry " + path + "[" + step.name + "]" : path + " is a list, which has no " + step.name;
            const std::string key = list->empty() || list->front().as<Value::Table>() ? "." + step.name : "";
            problems.push_back({value.place, wanted, step.is_index ? "" : "name an entry, as in " + path + "[0]" + key,
                                list->empty() ? "" : path + " has the entries 0 to " + std::to_string(list->size() - 1)});
            return;
        }
        if (step.index == list->size()) {
            list->emplace_back(Value::Table{});
            list->back().place = list->back().key_place = value.place;
        }
        put((*list)[step.index], steps, depth + 1, value, problems);
        return;
    }
    if (!node.as<Value::Table>()) {  // a plain value instead of a table: the change replaces it
        const Place place = value.place;
        node = Value(Value::Table{});
        node.place = node.key_place = place;
    }
    if (Value* child = node.find(step.name)) {
        put(*child, steps, depth + 1, value, problems);
        return;
    }
    // A list that the file does not have begins with its entry 0.
    Value child = depth + 1 < steps.size() && steps[depth + 1].is_index ? Value(Value::List{}) : Value(Value::Table{});
    child.place = child.key_place = value.key_place;
    put(child, steps, depth + 1, value, problems);
    node.as<Value::Table>()->emplace_back(step.name, std::move(child));
}

/// Numbers as people write them, .5 and 1., as TOML writes them.
std::string with_zeros(const std::string& text) {
    static const std::regex before("(^|[\\[,\\s+-])\\.(?=[0-9])"), after("([0-9])\\.(?=[\\],\\s]|$)");
    return std::regex_replace(std::regex_replace(text, before, "$010."), after, "$01.0");
}

std::size_t offset_of(const std::string& text, const toml::source_position& place) {
    std::size_t at = 0;
    for (toml::source_index line = 1; line < place.line && at < text.size(); ++line)
        at = std::min(text.find('\n', at), text.size() - 1) + 1;
    for (toml::source_index column = 1; column < place.column && at < text.size();)  // columns are characters, not bytes
        if ((text[++at] & 0xC0) != 0x80) ++column;
    return at;
}

bool begins(const std::string& text, std::initializer_list<const char*> beginnings) {
    return std::any_of(beginnings.begin(), beginnings.end(), [&](const char* b) { return text.rfind(b, 0) == 0; });
}

/// The way out of a mistake that is made often, from the text at the place where it stops being TOML.
std::string syntax_hint(const std::string& text, std::size_t at, const std::string& what) {
    const auto says = [&](const char* part) { return what.find(part) != std::string::npos; };
    const std::string rest = text.substr(at, text.find_first_of("\r\n", at) - at);
    if (says("utf-8") || text.find('\0') != std::string::npos) return "save the file as UTF-8";
    if (says("string") && rest.empty()) return "add the closing quote";
    if (says("expected '='") && rest[0] == ':') return "write = between a key and its value";
    if (begins(rest, {"\u2018", "\u2019", "\u201c", "\u201d", "\u201e", "\u00ab", "\u00bb"})) return "use straight quotes, \"";
    // The value that cannot be read begins after the last of these signs.
    std::size_t begin = at == 0 ? 0 : text.rfind('\n', at - 1) + 1;
    for (std::size_t i = begin; i < at;)
        if (text[i] == '"' || text[i] == '\'') i = end_of_quoted(text, i);
        else if (std::strchr("=[,{", text[i++]) != nullptr) begin = i;
    if (begin == 0 || std::strchr("=[,{", text[begin - 1]) == nullptr || says("table header") || says("redefine")) return "";
    const bool after_key = text[begin - 1] == '=';
    begin = std::min(text.find_first_not_of(" \t", begin), text.size());
    if (after_key && begin >= at && (rest.empty() || rest[0] == '#')) return "add a value";
    if (std::isalpha(static_cast<unsigned char>(text[begin])) != 0)
        return "put strings and expressions in quotes; booleans are true and false";
    return std::strchr("+-.0123456789", text[begin]) == nullptr
               ? ""
               : "write numbers as in 0.5 or 1e-3, without a unit; put expressions in quotes";
}

void set_place(Value& v, const Place& place) {
    v.place = v.key_place = place;
    if (auto* list = v.as<Value::List>())
        for (Value& child : *list) set_place(child, place);
    if (auto* table = v.as<Value::Table>())
        for (auto& [key, child] : *table) set_place(child, place);
}

}  // namespace

Value parse_toml(const std::string& text, const std::string& file) {
    check_nesting(text, file);
    try {
        return converted(toml::parse(text, file), file);
    } catch (const toml::parse_error& e) {
        const std::string what = message_of(e);
        throw InputError(place_of(e.source(), file), "not TOML: " + what, syntax_hint(text, offset_of(text, e.source().begin), what));
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

namespace {

std::string trimmed(const std::string& text) {
    const std::size_t begin = std::min(text.find_first_not_of(" \t"), text.size());
    return text.substr(begin, text.find_last_not_of(" \t") + 1 - begin);
}

}  // namespace

Change parse_change(const std::string& text, const std::string& option) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos) return {text, "", option + " " + text, false};
    return {trimmed(text.substr(0, equals)), trimmed(text.substr(equals + 1)), option + " " + text};
}

void apply_change(Value& root, const Change& change, std::vector<Problem>& problems) {
    const Place place{change.source, 0, 0};
    if (!change.complete || change.value.empty()) {
        problems.push_back({place, "a change needs a value", "", "allowed: key=value, as in fluid.viscosity=100"});
        return;
    }
    const std::vector<Step> steps = parse_path(change.key);
    if (steps.empty()) {
        problems.push_back(
            {place, "\"" + change.key + "\" is not a key", "", "allowed: names with dots between them, as in emitter[0].speed"});
        return;
    }
    Value value;
    try {
        check_nesting(change.value, change.source);
        const auto parsed = [](const std::string& text) { return *converted(toml::parse("value = " + text), "").find("value"); };
        try {
            value = parsed(change.value);
        } catch (const toml::parse_error&) { value = parsed(with_zeros(change.value)); }
    } catch (const toml::parse_error& e) {
        char* end = nullptr;
        const double number = std::strtod(change.value.c_str(), &end);  // 1e999
        // Values that begin like TOML must be TOML; others are texts, as in models.pressure=ppe.
        if (std::strchr("[{\"'", change.value[0]) != nullptr) {
            const bool list = change.value.front() == '[' && change.value.back() == ']';
            problems.push_back(
                {place, "the value is not TOML: " + message_of(e), list ? "put strings and expressions in a list in quotes" : "", ""});
            return;
        }
        value = *end == 0 ? Value(number) : Value(change.value);
    }
    set_place(value, place);
    put(root, steps, 0, value, problems);
}

void overlay(Value& root, const Value& table, const std::string& path, std::vector<Problem>& problems) {
    for (const auto& [key, value] : *table.as<Value::Table>()) {
        const std::string full = path.empty() ? key : path + "." + key;
        if (value.as<Value::Table>()) {
            overlay(root, value, full, problems);
        } else {
            const std::vector<Step> steps = parse_path(full);
            if (steps.empty()) problems.push_back({value.key_place, "\"" + key + "\" is not a key", "", ""});
            else put(root, steps, 0, value, problems);
        }
    }
}

}  // namespace whorl
