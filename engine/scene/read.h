#pragma once
/// Scene files: reading with every mistake in one go.
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "engine/core/keys.h"
#include "engine/scene/document.h"
#include "engine/scene/scene.h"

namespace whorl {

/// A section of the scene file that the engine does not define: [name], with the keys of `table`, read into `object`.
struct Section {
    std::string name;
    const KeyTable* table;
    void* object = nullptr;  ///< nullptr if only the table counts (schema)
};

struct ReadRequest {
    std::vector<KeyValue> changes;  ///< beat the file, the later the stronger
    std::string
        quality;  ///< "draft", "fine": the [quality.NAME] table of the file is laid over it, below the changes; "" or "standard": nothing
    std::vector<KeyValue> presets;      ///< lie between the file and its [quality] table: settings of that quality in every scene
    std::vector<std::string> overlays;  ///< scene files of a few keys, laid over the file and its quality, below the changes
    std::vector<Section> sections;
};

/// @throws InputError with all that is wrong in the file (syntax, unknown keys, types, ranges, missing keys, expressions, names given
/// twice, files that are not there) in the order of their places. Tables [quality.*] that were not asked for are checked just as well.
Scene read_scene(const std::string& file, const ReadRequest& request = {});
/// Reads a scene from a text. @param file its name in messages; mesh files are found from its folder
Scene read_scene_text(const std::string& text, const std::string& file, const ReadRequest& request = {});

/// The scene's name after its file: the stem, with _ for each character that names cannot have.
std::string scene_name(const std::filesystem::path& file);

/// JSON Schema (draft 7) of scene files, for editors.
std::string json_schema(const std::vector<Section>& sections = {});
/// The keys as a page of Markdown tables.
std::string markdown_reference(const std::vector<Section>& sections = {});

/// Every value used, as a scene file that reads back as the same scene.
std::string resolved_toml(const Scene& scene, const std::vector<Section>& sections = {});

nlohmann::ordered_json json_of(const Value& value);

const KeyTable& scene_keys();
/// Values of output.export; each is also the name of a folder in the run folder.
const std::vector<std::string>& export_kinds();

}  // namespace whorl
