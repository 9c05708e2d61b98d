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

/// The value with this place, also of its entries.
Value placed(Value v, const FileLocation& place);

/// A value as an option has it: TOML, or else a number or a text without quotes. @param source replaces file:line:column in messages
/// @throws InputError
Value parse_value(const std::string& text, const std::string& source = "");
/// From "emitter[0].speed=0.3" or "emitter.0.speed=0.3". @param option the option before it, for messages @throws InputError
KeyValue parse_change(const std::string& text, const std::string& option = "--set");

/// A key's full name: emitter.0.speed is emitter[0].speed.
std::string full_path(const std::string& path);

/// Sets a key of the tree; appends to `problems` where it is not a key, or names a list entry that is not there.
void set_key(Value& root, const KeyValue& change, std::vector<Problem>& problems);

/// Lays the entries of `table` over the tree: nested tables are followed (also into lists, by index), everything else replaces.
void overlay(Value& root, const Value& table, const std::string& path, std::vector<Problem>& problems);

}  // namespace whorl
