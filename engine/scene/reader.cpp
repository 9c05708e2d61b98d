#include "engine/scene/reader.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdlib>

namespace whorl {
namespace {

std::string in_quotes(const std::vector<std::string>& names) {
    std::string text;
    for (std::size_t i = 0; i < names.size(); ++i) text += (i == 0 ? "\"" : i + 1 == names.size() ? " or \"" : ", \"") + names[i] + "\"";
    return text;
}

/// Name of the selector in messages: "shape" is in the key's own table, "models.pressure" is a full name.
std::string selector_name(const Key& key, const std::string& path) {
    return key.selector.find('.') == std::string::npos ? joined_path(path, key.selector) : key.selector;
}

bool is_zero(const Value& v) {
    if (const std::string* text = v.as<std::string>()) {
        char* end = nullptr;
        return std::strtod(text->c_str(), &end) == 0 && end != text->c_str() && *end == 0;
    }
    return v.is_number() ? v.number() == 0 : v.as<bool>() && !*v.as<bool>();
}

/// Looks up former names of keys and values in the table or key `where`. @return the current name for `old`, "" if it is not a former name
std::string renamed(const std::string& where, const std::string& old) {
    struct Row {
        std::string where, old, now;
    };
    static const std::vector<Row> rows{
        {"solid", "inside", "container"}, {"solid", "spin", "rotation"},         {"solid", "centre", "position"},
        {"block", "centre", "position"},  {"heat", "specific_heat", "capacity"}, {"heat", "ambient", "air"},
        {"drain", "after", "delay"},      {"output", "frames", "images"},        {"models.micropolar", "seed", "notes"}};
    for (const Row& row : rows)
        if (row.where == where && row.old == old) return row.now;
    return "";
}

std::vector<std::string> names_in(const KeyTable& table) {
    std::vector<std::string> names;
    for (const Key& k : table.keys) names.push_back(k.name);
    for (const KeyTable::Part& p : table.parts) names.push_back(p.name);
    return names;
}

}  // namespace

Reader::Reader(const KeyTable& table, void* object, std::vector<Section> sections, bool plane)
    : root_{&table, object}, sections_(std::move(sections)), plane_(plane) {}

FileLocation Reader::place(const std::string& key) const { return place_in(places, key); }

void Reader::disagree(const std::vector<std::string>& keys, std::string what, std::string hint, std::string allowed) {
    for (const std::string& key : keys)
        if (failed_.count(key)) return;
    // Location of the first key that was given; the others have their defaults.
    FileLocation where = place(keys.front());
    for (const std::string& key : keys)
        if (const auto it = places.find(key); it != places.end()) {
            where = it->second;
            break;
        }
    problems.push_back({where, std::move(what), std::move(hint), std::move(allowed)});
}

/// A hint if another section has the key.
std::string Reader::key_elsewhere(const std::string& name) const {
    for (const KeyTable::Part& part : root_.table->parts)
        if (part.table->find_key(name)) return "[" + part.name + "] has a key of this name";
    return "";
}

void Reader::unknown(const Value& v, const std::string& name, const KeyTable& table, const std::string& path) {
    std::vector<std::string> names = names_in(table);
    if (path.empty())
        for (const Section& s : sections_) names.push_back(s.name);
    const std::string near = nearest_name(name, names);
    const std::string where = path.empty() ? "" : (path.back() == ']' ? " in " + path : " in [" + path + "]");
    std::string hint = near.empty() ? "" : "did you mean \"" + near + "\"?";
    if (near.empty()) hint = key_elsewhere(name);
    if (const std::string now = renamed(path.substr(0, path.find('[')), name); !now.empty()) hint = "it is called \"" + now + "\"";
    problems.push_back({v.key_place, "unknown key \"" + name + "\"" + where, hint, fmt::format("allowed: {}", fmt::join(names, ", "))});
}

void Reader::read_part(const KeyTable::Part& part, void* object, const Value& v, const std::string& path) {
    const auto wrong = [&](const FileLocation& where, const std::string& form) {
        problems.push_back({where, path + " must be " + form, "", ""});
        failed_.insert(path);
    };
    places[path] = v.place;
    if (!part.is_list) {
        void* inner = part.one(object);
        if (!v.as<Value::Table>()) {
            wrong(v.key_place, v.as<Value::List>() ? "one table, [" + path + "]" : "a table, [" + path + "]");
            if (!v.as<Value::List>()) problems.back().hint = key_elsewhere(part.name);
            return;
        }
        return read_table({part.table.get(), inner}, inner, v, path);
    }
    const Value::List* list = v.as<Value::List>();
    if (!list) return wrong(v.key_place, "a list of tables, [[" + path + "]]");
    part.resize(object, list->size());
    for (std::size_t i = 0; i < list->size(); ++i) {
        const Value& entry = (*list)[i];
        const std::string name = entry_name(path, i);
        if (!entry.as<Value::Table>()) {
            wrong(entry.place, "a list of tables, [[" + path + "]]");
            continue;
        }
        places[name] = entry.place;
        void* inner = part.at(object, i);
        read_table({part.table.get(), inner}, inner, entry, name);
    }
}

void Reader::read_key(const Key& key, void* object, const Value& v, const std::string& path) {
    places[path] = v.place;
    const std::size_t before = problems.size();
    const Value::List* list = v.as<Value::List>();
    key.read(object, plane_ ? key.with_depth(v) : v, path, problems);
    if (plane_ && problems.size() == before && list && list->size() == 3) check_in_plane(key, v, path);
    if (problems.size() == before) return;
    failed_.insert(path);
    if (const std::string* text = v.as<std::string>())
        if (const std::string now = renamed(path, *text); !now.empty()) problems.back().hint = "it is called \"" + now + "\"";
}

void Reader::check_in_plane(const Key& key, const Value& v, const std::string& path) {
    const Value::List& list = *v.as<Value::List>();
    const auto report = [&](const Value& wrong, const char* what, const char* allowed) {
        problems.push_back({wrong.place, path + " " + what + ": the flow has two dimensions (domain.dimensions)", "", allowed});
    };
    if (key.in_plane == InPlane::vector && !is_zero(list[2]))
        report(list[2], "leaves the plane",
               key.type == KeyType::flag ? "allowed: two flags, or false in the third place"
                                         : "allowed: two numbers, or 0 in the third place");
    for (int a = 0; a < 2; ++a)
        if (key.in_plane == InPlane::axis && !is_zero(list[a]))
            return report(list[a], "is not about the axis across the plane", "allowed: 0 in the first two places");
}

void Reader::read_table(const Described& here, void* object, const Value& v, const std::string& path) {
    for (const auto& [name, value] : *v.as<Value::Table>()) {
        const std::string full = joined_path(path, name);
        if (const Key* key = here.table->find_key(name)) {
            read_key(*key, object, value, full);
        } else if (const KeyTable::Part* part = here.table->find_part(name)) {
            read_part(*part, object, value, full);
        } else {
            const auto section = std::find_if(sections_.begin(), sections_.end(),
                                              [&, &wanted = name](const Section& s) { return path.empty() && s.name == wanted; });
            if (section == sections_.end()) {
                unknown(value, name, *here.table, path);
            } else if (!value.as<Value::Table>()) {
                problems.push_back({value.key_place, name + " must be a table, [" + name + "]", "", ""});
            } else {
                places[name] = value.place;
                read_table({section->table, section->object}, section->object, value, name);
            }
        }
    }
}

bool Reader::chosen_by_option(const std::string& selector, const std::string& full) const {
    const auto is_option = [&](const std::string& name) {
        const auto it = places.find(name);
        return it != places.end() && it->second.line == 0;  // a key from a file has a line, an option has none
    };
    return !is_option(full) && (is_option(selector) || left_out_.count(selector) > 0);
}

/// Reports keys that belong to another shape or model than the chosen one, and required keys that are missing.
void Reader::check_selected(const Described& here, const std::string& path) {
    for (const Key& key : here.table->keys) {
        const std::string full = joined_path(path, key.name);
        const std::string selector = key.selector.empty() ? "" : selector_name(key, path);
        if (failed_.count(selector)) continue;
        const bool given = places.count(full) > 0, counted = counts(key, here, root_);
        if (given && !counted && chosen_by_option(selector, full)) {
            left_out_.insert(full);
            places.erase(full);
        } else if (given && !counted && !failed_.count(full) && !sets_one_of(panel_sets_, selector, key.selected_by)) {
            const std::string value = selector_value(key, here, root_);
            std::vector<std::string> valid;
            for (const Key& k : here.table->keys)
                if (k.selector == key.selector && counts(k, here, root_)) valid.push_back(k.name);
            problems.push_back({place(full),
                                full + " belongs to " + selector + " = " + in_quotes(key.selected_by) + ", not to \"" + value + "\"",
                                "remove it, or change " + selector,
                                valid.empty() ? "" : fmt::format("keys of \"{}\": {}", value, fmt::join(valid, ", "))});
            failed_.insert(full);
        }
        if (key.is_required && counted && !given) {
            const std::string unit = key.unit.empty() ? "" : " [" + key.unit + "]";
            problems.push_back(
                {place(path), full + " is missing", key.meaning + unit, key.allowed().empty() ? "" : "allowed: " + key.allowed()});
            failed_.insert(full);
        }
    }
    each_part(here, path, [&](const KeyTable::Part&, const std::string& name, const Described& part) {
        if (!failed_.count(name)) check_selected(part, name);
    });
}

void Reader::read(const Value& root) {
    places[""] = {root.place.file, 0, 0};
    read_table(root_, const_cast<void*>(root_.object), root, "");
    const Value* panels = root.find("panel");
    if (const Value::List* list = panels ? panels->as<Value::List>() : nullptr)
        for (const Value& panel : *list)
            if (const Value* set = panel.find("set"); set && set->as<Value::List>())
                for (const Value& text : *set->as<Value::List>())
                    if (text.as<std::string>()) panel_sets_.push_back(*text.as<std::string>());
    check_selected(root_, "");
    for (const Section& s : sections_) check_selected({s.table, s.object}, s.name);
}

}  // namespace whorl
