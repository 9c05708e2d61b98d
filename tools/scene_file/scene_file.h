#pragma once
/// Reads a scene file and applies the options of the command line.
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "engine/scene/plan.h"
#include "engine/scene/read.h"
#include "render/look/camera.h"
#include "render/look/look_options.h"
#include "render/surface/surface.h"
#include "tools/scene_file/options.h"

namespace whorl {

/// Settings of a scene file: for the engine and for the images.
struct SceneFile {
    Scene scene;
    SurfaceOptions surface;
    CameraOptions camera;
    LookOptions look;
};

/// Reads options.scene and applies --with, --set, --quality, --until, --size, --fps, --seed, --export, --no-video and --no-images.
/// @throws InputError with all problems, their locations and hints
SceneFile read_scene_file(const Options& options);
/// Reads a resolved scene (resume, video).
SceneFile read_scene_file(const std::filesystem::path& file, const std::vector<std::string>& set = {});
/// Reads a scene from its text, as stored in a checkpoint. @param file its name in messages; paths of meshes are relative to its folder
SceneFile read_resolved(const std::string& text, const std::string& file);
/// Makes the path of look.environment absolute, relative to the scene file's folder, and reads the image as a check.
/// @throws InputError with the location of the key if the image cannot be read
void find_environment(SceneFile& file);
/// Checksums of the meshes, images and tables that the scene names, by absolute path. @throws InputError if one cannot be read
std::map<std::string, std::uint64_t> input_checksums(const SceneFile& file);
/// Hash of the scene and of the files that it names. @throws InputError as input_checksums()
std::size_t input_hash(const SceneFile& file);
/// Text of scene.resolved.toml, with every value in use. Reading it gives the same scene.
std::string resolved_toml(const SceneFile& file);

/// Warns if the camera is at its target, looks along camera.up, does not see the domain, or is so far away that the domain covers less
/// than 2 % of the image's height.
std::vector<std::string> camera_warnings(const SceneFile& file);
/// Plan of the scene, with the warnings about its camera.
Plan make_plan(const SceneFile& file);

/// Shipped scenes: name and path, sorted by name.
std::vector<std::pair<std::string, std::filesystem::path>> shipped_scenes();
/// Names of the shipped scenes, except those of scenes/studies.
std::vector<std::string> film_names();
/// Path of a scene: `name` itself if the file exists, otherwise <name>.toml among the shipped scenes (in the installed share folder or the
/// source tree). @throws InputError with the nearest name
std::filesystem::path find_scene(const std::string& name);
/// As find_scene(), for the file of a sweep (whorl tradeoff, whorl stability).
std::filesystem::path find_study(const std::string& name);

/// Sections of a scene file outside the engine, for the schema: surface, camera, look.
std::vector<Section> known_sections();

}  // namespace whorl
