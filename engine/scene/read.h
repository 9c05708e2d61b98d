#pragma once
/// Reading of scene files, with all mistakes reported together.
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "engine/core/keys.h"
#include "engine/scene/document.h"
#include "engine/scene/scene.h"

namespace whorl {

/// A section of the scene file that the engine does not define: [name] with the keys of `table`, read into `object`.
struct Section {
    std::string name;
    const KeyTable* table;
    void* object = nullptr;  ///< nullptr if only the table is needed (schema)
};

struct ReadRequest {
    std::vector<KeyValue> changes;  ///< override the file; later ones override earlier ones
    std::string
        quality;  ///< "draft", "fine": the file's table [quality.NAME] overrides the file, below `changes`; "" or "standard": no table
    std::vector<KeyValue> presets;      ///< settings of that quality for every scene; they override the file, below its [quality] table
    std::vector<std::string> overlays;  ///< scene files with a few keys that override the file and its quality, below `changes`
    std::vector<Section> sections;
};

/// @throws InputError with all faults of the file (syntax, unknown keys, types, ranges, missing keys, expressions, duplicate names,
/// missing files), sorted by location. Tables [quality.*] that were not requested are also checked.
Scene read_scene(const std::string& file, const ReadRequest& request = {});
/// Reads a scene from a text. @param file its name in messages; mesh files are searched from its folder
Scene read_scene_text(const std::string& text, const std::string& file, const ReadRequest& request = {});

/// Whether files and folders of the run can have this name.
bool is_file_name(const std::string& text);
/// The scene's name from its file: the stem, with _ for each character that names cannot contain.
std::string scene_name(const std::filesystem::path& file);

/// JSON Schema (draft 7) of scene files, for editors.
std::string json_schema(const std::vector<Section>& sections = {});
/// The keys as a page of Markdown tables.
std::string markdown_reference(const std::vector<Section>& sections = {});

/// All values in use, as a scene file that reads back as the same scene.
std::string resolved_toml(const Scene& scene, const std::vector<Section>& sections = {});

nlohmann::ordered_json json_of(const Value& value);

const KeyTable& scene_keys();
/// Values of output.export; each is also the name of a folder in the run folder.
const std::vector<std::string>& export_kinds();

}  // namespace whorl
