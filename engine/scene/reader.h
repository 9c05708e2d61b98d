#pragma once
/// Fills structs from a tree of values by their key tables, and collects all mistakes.
#include <map>
#include <set>
#include <string>
#include <vector>

#include "engine/scene/read.h"
#include "engine/scene/tree.h"

namespace whorl {

class Reader {
public:
    /// @param plane whether the flow is 2D
    Reader(const KeyTable& table, void* object, std::vector<Section> sections, bool plane = false);

    void read(const Value& root);

    std::vector<Problem> problems;
    std::map<std::string, FileLocation> places;  ///< of every key and table that was given

    /// Reports keys that contradict each other, unless one of them is itself invalid or missing.
    void disagree(const std::vector<std::string>& keys, std::string what, std::string hint = "", std::string allowed = "");
    FileLocation place(const std::string& key) const;

private:
    void read_table(const Described& here, void* object, const Value& v, const std::string& path);
    void read_key(const Key& key, void* object, const Value& v, const std::string& path);
    void check_in_plane(const Key& key, const Value& v, const std::string& path);
    void read_part(const KeyTable::Part& part, void* object, const Value& v, const std::string& path);
    std::string key_elsewhere(const std::string& name) const;
    void unknown(const Value& v, const std::string& name, const KeyTable& table, const std::string& path);
    /// Whether an option (--set) chose a value that disables the key `full` of the file. The key is then ignored, so that an option can
    /// choose another style without an edit of the file.
    bool chosen_by_option(const std::string& selector, const std::string& full) const;
    void check_selected(const Described& here, const std::string& path);

    Described root_;
    std::vector<Section> sections_;
    bool plane_;
    std::vector<std::string> panel_sets_;  ///< settings of panels, "key=value"
    std::set<std::string> failed_, left_out_;
};

/// Reports keys that contradict each other, and derives values that the file leaves out.
void make_consistent(Scene& scene, Reader& reader);

}  // namespace whorl
