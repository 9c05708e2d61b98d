#pragma once
/// Traversal of a struct by its key table.
#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "engine/core/keys.h"

namespace whorl {

/// A struct in memory with the table that describes it.
struct Described {
    const KeyTable* table;
    const void* object;
};

/// "emitter[2]"
inline std::string entry_name(const std::string& list, std::size_t i) { return list + "[" + std::to_string(i) + "]"; }
inline std::string point_text(const Vec3d& x) { return fmt::format("({:.4g}, {:.4g}, {:.4g})", x.x(), x.y(), x.z()); }
inline std::string joined_path(const std::string& path, const std::string& name) { return path.empty() ? name : path + "." + name; }

/// Location of a key in its file, or of the nearest enclosing table that was given. @param places locations of given keys, by full names
inline FileLocation place_in(const std::map<std::string, FileLocation>& places, const std::string& key) {
    for (std::string path = key; !path.empty();) {
        if (const auto it = places.find(path); it != places.end()) return it->second;
        const std::size_t end = path.find_last_of(".[");
        path.resize(end == std::string::npos ? 0 : end);
    }
    const auto it = places.find("");
    return it == places.end() ? FileLocation{} : it->second;
}

/// The key that selects another one, and the struct that contains it: in the same table (`shape`) or from the root (`models.pressure`).
struct Selector {
    const Key* key;
    Described in;
};
inline Selector selector_of(const Key& key, const Described& here, const Described& root) {
    const std::size_t dot = key.selector.find('.');
    if (dot == std::string::npos) return {here.table->find_key(key.selector), here};
    const KeyTable::Part* part = root.table->find_part(key.selector.substr(0, dot));
    const Described in{part->table.get(), part->one(const_cast<void*>(root.object))};
    return {in.table->find_key(key.selector.substr(dot + 1)), in};
}

/// The selector's current value.
inline std::string selector_value(const Key& key, const Described& here, const Described& root) {
    const Selector selector = selector_of(key, here, root);
    return *selector.key->get(selector.in.object).as<std::string>();
}

/// Whether the key is used: the chosen shape or model is one of those to which the key belongs, and its selector is used.
inline bool counts(const Key& key, const Described& here, const Described& root) {
    if (key.selector.empty()) return true;
    const Selector selector = selector_of(key, here, root);
    if (!counts(*selector.key, selector.in, root)) return false;
    const std::string value = selector_value(key, here, root);
    const bool model = key.selector.find('.') != std::string::npos;  // a model set to "auto" may become any of them
    return (model && value == "auto") || std::find(key.selected_by.begin(), key.selected_by.end(), value) != key.selected_by.end();
}

/// Calls f(part, path, described part) for every nested struct, and for every entry of lists of structs.
template <class F>
void each_part(const Described& here, const std::string& path, F&& f) {
    for (const KeyTable::Part& part : here.table->parts) {
        void* object = const_cast<void*>(here.object);
        const std::string name = joined_path(path, part.name);
        if (!part.is_list) {
            f(part, name, Described{part.table.get(), part.one(object)});
            continue;
        }
        for (std::size_t i = 0; i < part.size(object); ++i) f(part, entry_name(name, i), Described{part.table.get(), part.at(object, i)});
    }
}

/// Whether a panel's texts "key=value" set the key to one of these values.
inline bool sets_one_of(const std::vector<std::string>& set, const std::string& key, const std::vector<std::string>& values) {
    return std::any_of(set.begin(), set.end(), [&](std::string text) {
        std::erase_if(text, [](char c) { return c == ' ' || c == '"'; });
        return std::any_of(values.begin(), values.end(), [&](const std::string& value) { return text == key + "=" + value; });
    });
}

}  // namespace whorl
