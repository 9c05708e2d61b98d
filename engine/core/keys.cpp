#include "engine/core/keys.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace whorl {
namespace {

std::string quoted(const std::string& text) {
    std::string out = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\') out += '\\', out += c;
        else if (c == '\n') out += "\\n";
        else if (c == '\t') out += "\\t";
        else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) out += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
        else out += c;
    }
    return out + '"';
}

std::string number_text(double v) {
    std::string text = fmt::format("{}", v);
    if (text.find_first_of(".ein") == std::string::npos) text += ".0";
    return text;
}

bool bare(const std::string& key) {
    return !key.empty() && std::all_of(key.begin(), key.end(), [](unsigned char c) { return std::isalnum(c) || c == '_' || c == '-'; });
}

std::string in_words(const Value& v) {
    switch (v.data.index()) {
        case 1: return *v.as<bool>() ? "true" : "false";
        case 2:
        case 3: return "the number " + v.toml();
        case 4: return "the text " + v.toml();
        case 5: return "a list of " + std::to_string(v.as<Value::List>()->size());
        case 6: return "a table";
        default: return "a date or time";
    }
}

/// A number as people write ranges: 1, not 1.0.
std::string plain(double v) { return fmt::format("{}", v); }

bool fits(KeyType type, const Value& v) {
    switch (type) {
        case KeyType::flag: return v.as<bool>() != nullptr;
        case KeyType::integer: return v.is_number() && std::floor(v.number()) == v.number();
        case KeyType::number: return v.is_number();
        case KeyType::expression: return v.is_number() || v.as<std::string>();
        case KeyType::any: return v.data.index() > 0 && !v.as<Value::Table>();
        default: return v.as<std::string>() != nullptr;
    }
}

}  // namespace

const Value* Value::find(const std::string& key) const {
    if (const Table* table = as<Table>())
        for (const auto& [name, value] : *table)
            if (name == key) return &value;
    return nullptr;
}

std::string Value::toml() const {
    if (const bool* flag = as<bool>()) return *flag ? "true" : "false";
    if (const auto* whole = as<std::int64_t>()) return std::to_string(*whole);
    if (const double* number = as<double>()) return number_text(*number);
    if (const std::string* text = as<std::string>()) return quoted(*text);
    std::string out;
    if (const List* list = as<List>()) {
        for (const Value& v : *list) out += (out.empty() ? "" : ", ") + v.toml();
        return "[" + out + "]";
    }
    if (const Table* table = as<Table>()) {
        for (const auto& [key, v] : *table) out += (out.empty() ? "" : ", ") + (bare(key) ? key : quoted(key)) + " = " + v.toml();
        return "{" + out + "}";
    }
    return "\"\"";
}

double shortest_decimal(float v) { return std::isfinite(v) ? std::strtod(fmt::format("{}", v).c_str(), nullptr) : static_cast<double>(v); }

Value Key::with_depth(const Value& v) const {
    const Value::List* list = v.as<Value::List>();
    if (!may_lack_depth() || !list || list->size() != 2) return v;
    Value in_space = v, zero = type == KeyType::flag ? Value(false) : Value(0.0);
    zero.place = v.place;
    in_space.as<Value::List>()->push_back(std::move(zero));
    return in_space;
}

Key& Key::one_of(std::vector<std::string> names) {
    choices = std::move(names);
    return *this;
}

std::string Key::type_name() const {
    const std::string list = is_list ? "a list of " + (count > 0 ? std::to_string(count) + " " : "") : "";
    switch (type) {
        case KeyType::flag: return is_list ? list + "booleans" : "true or false";
        case KeyType::integer: return is_list ? list + "whole numbers" : "a whole number";
        case KeyType::number:
            if (is_list) return list + "numbers" + (access->from_text ? " or a text" : "");
            return may_be_auto ? "a number or \"auto\"" : "a number";
        case KeyType::text: return is_list ? list + "texts" : "a text";
        case KeyType::expression: return is_list ? list + "numbers or expressions in quotes" : "a number or an expression in quotes";
        case KeyType::any: return "any value that the key accepts";
    }
    return "";
}

std::string Key::allowed() const { return allowed_beside(0); }

std::string Key::allowed_beside(double x) const {
    std::string text;
    if (!choices.empty()) {
        for (std::size_t i = 0; i < choices.size(); ++i)
            text += (i == 0 ? "" : i + 1 == choices.size() ? (is_list ? ", " : " or ") : ", ") + choices[i];
        if (may_be_auto) text = "auto, " + text;
        return text;
    }
    // The limits of the C++ type mean nothing to users, so they are shown only if the number x is beyond them.
    const double largest = single ? shortest_decimal(std::numeric_limits<float>::max()) : std::numeric_limits<double>::max();
    const double low = std::max(least, -largest), high = std::min(most, largest);
    const bool shown = std::isfinite(x) || single, bounded_below = std::abs(low) < 2e9 || (shown && x < low),
               bounded_above = std::abs(high) < 2e9 || (shown && x > high);
    if (bounded_below) text = (least_open ? "more than " : "at least ") + plain(low);
    if (bounded_above) text += (text.empty() ? "at most " : ", at most ") + plain(high);
    return text;
}

Key& Key::only_with(std::string_view key, std::initializer_list<const char*> values) {
    return selector = key, selected_by.assign(values.begin(), values.end()), *this;
}
Key& Key::only_with(std::string_view key, const std::vector<std::string>& values) { return selector = key, selected_by = values, *this; }

void Key::read(void* object, const Value& v, const std::string& path, std::vector<Problem>& problems) const {
    if (may_be_auto && v.as<std::string>() && *v.as<std::string>() == "auto") return access->read(static_cast<char*>(object) + offset, v);
    if (access->from_text && v.as<std::string>()) try {
            return read(object, access->from_text(v), path, problems);
        } catch (const KeyFault& fault) { return problems.push_back({fault.place, path + ": " + fault.what(), "", ""}); }
    bool good = true;
    if (!is_list) {
        if (!fits(type, v)) return wrong_type(v.place, in_words(v), path, problems);
        good = check_entry(v, path, problems);
    } else {
        const Value::List* list = v.as<Value::List>();
        if (!list || (count > 0 && list->size() != static_cast<std::size_t>(count))) {
            wrong_type(v.place, in_words(v), path, problems);
            if (!list && count > 0 && standard.as<Value::List>())
                problems.back().hint = "as in " + standard.toml();  // brackets are missing
            if (v.as<std::string>() && type == KeyType::text) problems.back().hint = "as in [" + v.toml() + "]";
            return;
        }
        for (std::size_t i = 0; i < list->size(); ++i) {
            const Value& e = (*list)[i];
            if (!fits(type, e)) return wrong_type(e.place, in_words(e) + " in place " + std::to_string(i + 1), path, problems);
            good &= check_entry(e, path + "[" + std::to_string(i) + "]", problems);
        }
    }
    if (good && assign(object, v, path, problems)) check_expressions(object, v, path, problems);
}

void Key::wrong_type(const FileLocation& place, const std::string& found, const std::string& path, Problems& problems) const {
    const std::string of_unit = unit.empty() ? "" : " [" + unit + "]";
    problems.push_back(
        {place, path + " must be " + type_name() + of_unit + ", not " + found, "", choices.empty() ? "" : "allowed: " + allowed()});
}

bool Key::check_entry(const Value& entry, const std::string& path, Problems& problems) const {
    const bool counts = type == KeyType::number || type == KeyType::integer || type == KeyType::expression;
    const bool in_range = !counts || !entry.is_number() || check_range(entry.number(), entry.place, path, problems);
    return check_choice(entry, path, problems) && in_range;
}

bool Key::check_range(double x, const FileLocation& place, const std::string& path, Problems& problems) const {
    const double held = single ? static_cast<double>(static_cast<float>(x)) : x;
    if (std::isfinite(held) && x >= least && x <= most && !(least_open && held == least)) return true;
    const std::string rule = allowed_beside(x);
    const std::string what = std::isfinite(x) ? " is out of range" : " is not a finite number";
    problems.push_back({place, path + " = " + plain(x) + what, "", rule.empty() ? "" : "allowed: " + rule});
    return false;
}

bool Key::check_choice(const Value& entry, const std::string& path, Problems& problems) const {
    const std::string* text = entry.as<std::string>();
    if (!text || choices.empty() || std::find(choices.begin(), choices.end(), *text) != choices.end()) return true;
    std::vector<std::string> names = choices;
    if (may_be_auto) names.emplace_back("auto");
    const std::string near = nearest_name(*text, names);
    problems.push_back({entry.place, path + " = " + entry.toml() + " is not known", near.empty() ? "" : "did you mean \"" + near + "\"?",
                        "allowed: " + allowed()});
    return false;
}

bool Key::assign(void* object, const Value& v, const std::string& path, Problems& problems) const {
    try {
        access->read(static_cast<char*>(object) + offset, v);
        return true;
    } catch (const KeyFault& fault) {
        problems.push_back(
            {fault.place, path + ": " + fault.what(), "", variables.empty() ? "" : "allowed: functions of " + variable_names(variables)});
        return false;
    }
}

void Key::check_expressions(const void* object, const Value& v, const std::string& path, Problems& problems) const {
    if (!access->constants) return;
    const void* expressions = static_cast<const char*>(object) + offset;
    for (const double x : access->constants(expressions)) check_range(x, v.place, path, problems);
    for (const char c : access->variables(expressions))
        if (variables.find(c) == std::string::npos)
            problems.push_back({v.place, path + " uses " + variable_name(c) + ", which it cannot depend on", "",
                                variables.empty() ? "allowed: a constant" : "allowed: functions of " + variable_names(variables)});
}

Key& KeyTable::add(Key key, std::string_view name, std::string_view unit, std::string_view what, const void* fresh) {
    key.name = name, key.unit = unit, key.meaning = what;
    key.standard = key.get(fresh);
    keys.push_back(std::move(key));
    return keys.back();
}

const Key* KeyTable::find_key(const std::string& name) const {
    for (const Key& k : keys)
        if (k.name == name) return &k;
    return nullptr;
}

const KeyTable::Part* KeyTable::find_part(const std::string& name) const {
    for (const Part& p : parts)
        if (p.name == name) return &p;
    return nullptr;
}

}  // namespace whorl
