#pragma once
/// A scene file as a tree of values with their locations, before key tables read it. Only document.cpp includes toml++.
#include <string>
#include <vector>

#include "engine/core/keys.h"

namespace whorl {

/// The tree of a TOML text. @param file name of the file for locations. @throws InputError for the first syntax error
Value parse_toml(const std::string& text, const std::string& file);
/// The tree of a TOML file. @throws InputError also if the file is missing or unreadable
Value parse_toml_file(const std::string& file);

/// The value with this location, set also for its entries.
Value placed(Value v, const FileLocation& place);

/// A value of a command-line option: TOML, or a number or text without quotes. @param source replaces file:line:column in messages
/// @throws InputError
Value parse_value(const std::string& text, const std::string& source = "");
/// Parses "emitter[0].speed=0.3" or "emitter.0.speed=0.3". @param option name of the option, for messages @throws InputError
KeyValue parse_change(const std::string& text, const std::string& option = "--set");

/// Full name of a key: emitter.0.speed becomes emitter[0].speed.
std::string full_path(const std::string& path);

/// Sets a key of the tree. Appends to `problems` if it is not a key or names a list entry that does not exist.
void set_key(Value& root, const KeyValue& change, std::vector<Problem>& problems);

/// Merges the entries of `table` into the tree. Nested tables are merged (also into lists, by index); all other values replace.
void overlay(Value& root, const Value& table, const std::string& path, std::vector<Problem>& problems);

}  // namespace whorl
