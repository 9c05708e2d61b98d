#include "engine/scene/read.h"

#include <algorithm>
#include <filesystem>

#include "engine/core/utf8.h"
#include "engine/scene/reader.h"

namespace whorl {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t longest_name = 200;  ///< file names get endings in addition, and the system's limit is 255 bytes
/// Letters of all languages are allowed: they are UTF-8 bytes beyond ASCII.
bool in_file_name(unsigned char c) { return c >= 0x80 || std::isalnum(c) != 0 || c == '_' || c == '-' || c == '.'; }

/// Whether the flow is 2D: by domain.dimensions, or if that is not given, by a domain without depth.
bool is_plane(const Value& root) {
    const Value* domain = root.find("domain");
    if (!domain) return false;
    if (const Value* given = domain->find("dimensions")) return given->is_number() && given->number() == 2;
    const auto depth = [&](const char* key) -> std::optional<double> {
        const Value* v = domain->find(key);
        const Value::List* list = v ? v->as<Value::List>() : nullptr;
        if (list && list->size() == 2) return 0;
        return list && list->size() == 3 && (*list)[2].is_number() ? std::optional<double>((*list)[2].number()) : std::nullopt;
    };
    return depth("min") && depth("min") == depth("max");
}

/// Reads one tree. The scene is complete only if no problem was found.
void read_tree(const Value& root, const std::string& file, const std::vector<Section>& sections, Scene& scene,
               std::vector<Problem>& problems) {
    scene.directory = fs::path(file).parent_path().string();
    scene.name = scene_name(file);
    const bool plane = is_plane(root);
    Reader reader(scene_keys(), &scene, sections, plane);
    reader.read(root);
    if (plane) scene.domain.dimensions = 2, scene.domain.min.z() = scene.domain.max.z() = 0;
    make_consistent(scene, reader);
    problems.insert(problems.end(), reader.problems.begin(), reader.problems.end());
    scene.places = std::move(reader.places);
}

/// Removes [quality] from the tree and returns its valid tables.
Value take_quality(Value& root, std::vector<Problem>& problems) {
    Value::Table& entries = *root.as<Value::Table>();
    const auto it = std::find_if(entries.begin(), entries.end(), [](const auto& e) { return e.first == "quality"; });
    Value quality{Value::Table{}};
    if (it == entries.end()) return quality;
    if (it->second.as<Value::Table>()) quality = std::move(it->second);
    else problems.push_back({it->second.key_place, "quality must be a table, as in [quality.draft]", "", ""});
    entries.erase(it);
    Value::Table valid;
    for (auto& [name, table] : *quality.as<Value::Table>()) {
        if (name == "standard")
            problems.push_back(
                {table.key_place, "[quality.standard] cannot be set", "the file itself is the standard quality", "allowed: draft, fine"});
        else if (name != "draft" && name != "fine")
            problems.push_back({table.key_place, "unknown quality \"" + name + "\"", "", "allowed: draft, fine"});
        else if (!table.as<Value::Table>())
            problems.push_back({table.key_place, "quality." + name + " must be a table, [quality." + name + "]", "", ""});
        else valid.emplace_back(name, std::move(table));
    }
    return Value(std::move(valid));
}

/// Checks a quality that was not chosen, and reports its problems.
void check_quality(Value root, const Value& table, const std::string& file, const std::vector<Section>& sections,
                   std::vector<Problem>& problems) {
    std::vector<Problem> found;
    overlay(root, table, "", found);
    std::vector<Section> scratch = sections;
    std::vector<std::shared_ptr<void>> keep;
    for (Section& s : scratch) keep.push_back(s.table->make()), s.object = keep.back().get();
    Scene scene;
    read_tree(root, file, scratch, scene, found);
    problems.insert(problems.end(), found.begin(), found.end());
}

Scene read_root(Value root, const std::string& file, const ReadRequest& request) {
    std::vector<Problem> problems;
    const Value quality = take_quality(root, problems);
    for (const auto& [name, table] : *quality.as<Value::Table>())
        if (name != request.quality) check_quality(root, table, file, request.sections, problems);
    if (!request.quality.empty() && request.quality != "standard") {
        for (const KeyValue& change : request.presets) set_key(root, change, problems);
        if (const Value* table = quality.find(request.quality)) overlay(root, *table, "", problems);
    }
    for (const std::string& overlay_file : request.overlays) overlay(root, parse_toml_file(overlay_file), "", problems);
    for (const KeyValue& change : request.changes) set_key(root, change, problems);
    Scene scene;
    read_tree(root, file, request.sections, scene, problems);
    if (!problems.empty()) throw InputError(in_order(std::move(problems), file));
    return scene;
}

}  // namespace

bool is_file_name(const std::string& text) {
    return !text.empty() && text.size() <= longest_name && text[0] != '.' && text[0] != '-' && is_utf8(text) &&
           std::all_of(text.begin(), text.end(), in_file_name);
}

std::string scene_name(const fs::path& file) {
    const std::string stem = file.stem().string();
    const bool text = is_utf8(stem);
    std::string name;
    for (const char c : stem) {
        const auto byte = static_cast<unsigned char>(c);
        const bool at_start = name.empty() && (c == '-' || c == '.');
        if ((byte < 0x80 || text) && !at_start && in_file_name(byte)) name += c;
        else if ((byte & 0xC0) != 0x80) name += '_';  // one per character
    }
    if (name.size() > longest_name) name.resize(longest_name);
    while (!is_utf8(name)) name.pop_back();  // remove the start of a cut character
    return name.empty() ? "scene" : name;
}

Scene read_scene(const std::string& file, const ReadRequest& request) { return read_root(parse_toml_file(file), file, request); }

Scene read_scene_text(const std::string& text, const std::string& file, const ReadRequest& request) {
    return read_root(parse_toml(text, file), file, request);
}

}  // namespace whorl
