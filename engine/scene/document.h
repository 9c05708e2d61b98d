#pragma once
/// A scene file as a tree of values with their places, before any key table looks at it. The only place that includes toml++.
#include <string>
#include <vector>

#include "engine/core/keys.h"

namespace whorl {

/// The tree of a TOML text. @param file its name in places. @throws InputError for the first mistake in the syntax
Value parse_toml(const std::string& text, const std::string& file);
/// The tree of a TOML file. @throws InputError if it is missing or unreadable too
Value parse_toml_file(const std::string& file);

/// A change to a tree that overrides existing values: "emitter[0].speed" or "emitter.0.speed", and the value as TOML writes it (a bare word
/// is a text).
struct Change {
    std::string key, value;
    std::string source;    ///< replaces file:line:column in messages: "--set emitter[0].speed=0.3"
    bool complete = true;  ///< false: the user gave no value
};
/// From "key=value". @param option the option before it, "--set"
Change parse_change(const std::string& text, const std::string& option = "--set");

/// Makes the change; appends to `problems` where its key or value cannot be read, or where it names a list entry that is not there.
void apply_change(Value& root, const Change& change, std::vector<Problem>& problems);

/// Lays the entries of `table` over the tree: nested tables are followed (also into lists, by index), everything else replaces.
void overlay(Value& root, const Value& table, const std::string& path, std::vector<Problem>& problems);

}  // namespace whorl
