#pragma once
/// A scene file as the options of the command line change it.
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "engine/scene/read.h"
#include "render/look/camera.h"
#include "render/look/look_options.h"
#include "render/surface/surface.h"
#include "tools/scene_file/options.h"

namespace whorl {

/// All that a scene file says: for the engine, and for the picture.
struct SceneFile {
    Scene scene;
    SurfaceOptions surface;
    CameraOptions camera;
    LookOptions look;
};

/// Reads options.scene with the changes that --set, --quality, --until, --size, --fps, --seed, --export, --no-video and --no-images ask
/// for.
/// @throws InputError with all that is wrong, places and hints
SceneFile read_scene_file(const Options& options);
/// Reads a resolved scene back (resume, video).
SceneFile read_scene_file(const std::filesystem::path& file, const std::vector<std::string>& set = {});
/// Reads a scene from its text, as stored in a checkpoint. @param file its name in messages; mesh files are found from its folder
SceneFile read_resolved(const std::string& text, const std::string& file);
/// Finds the picture of the surroundings from the scene file's folder. @throws InputError at its key if it cannot be read
void find_environment(SceneFile& file);
/// The checksum of each mesh, picture and table that the scene names, by absolute path. @throws InputError if one cannot be read
std::map<std::string, std::uint64_t> input_checksums(const SceneFile& file);
/// scene.resolved.toml: every value used. Reading it back gives the same scene.
std::string resolved_toml(const SceneFile& file);

/// The scenes that ship, by name.
std::vector<std::pair<std::string, std::filesystem::path>> shipped_scenes();
/// The shipped scenes that are films, not scenes of studies.
std::vector<std::string> film_names();
/// The file that `name` means: itself where it exists, else <name>.toml among the scenes that ship (installed share folder, or the source
/// tree).
/// @throws InputError with the nearest name
std::filesystem::path find_scene(const std::string& name);
/// find_scene() for a sweep (whorl tradeoff, whorl stability).
std::filesystem::path find_study(const std::string& name);

/// The scene file's sections that are not the engine's: surface, camera, look. For the schema.
std::vector<Section> known_sections();

}  // namespace whorl
