#pragma once
/// The options that several subcommands share, and the scene file as they change it.
#include <array>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

#include "engine/scene/write.h"
#include "render/look/look.h"
#include "render/surface/surface.h"

namespace CLI {
class App;
}

namespace whorl {

struct Options {
    std::string scene;                         ///< a path, or the bare name of a scene that ships
    std::vector<std::string> set;              ///< "key=value"
    std::vector<std::string> with;             ///< files of a few keys that are laid over the scene
    std::filesystem::path out;                 ///< empty: out/<scene name>
    std::optional<double> until;               ///< s; time.end
    std::optional<int> frames;                 ///< stop after so many frames (render counts them; not a key of the scene)
    std::string size;                          ///< "1280x720"; output.size
    std::optional<double> fps;                 ///< time.fps
    std::string quality = "standard";          ///< draft | standard | fine: the [quality.*] table that is laid over the scene
    bool no_video = false, no_images = false;  ///< output.video, output.frames
    std::vector<std::string> exports;          ///< output.export
    int threads = 0;                           ///< 0: all cores
    std::optional<std::uint64_t> seed;         ///< seed
    bool dry_run = false, quiet = false, json = false;
};

enum class Option {
    scene,
    set,
    with,
    out,
    until,
    frames,
    size,
    fps,
    quality,
    no_video,
    no_images,
    exports,
    threads,
    seed,
    dry_run,
    quiet,
    json
};

/// Adds those options to a subcommand; `options` must outlive the parsing (keep it in a shared_ptr that the callback holds).
void add_options(CLI::App& subcommand, Options& options, std::initializer_list<Option> which);

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
/// The same from its text, as a checkpoint keeps it. @param file stands for it in messages
SceneFile read_resolved(const std::string& text, const std::string& file);
/// scene.resolved.toml: every value used. Reading it back gives the same scene.
std::string resolved_toml(const SceneFile& file);

/// The scenes that ship, by name.
std::vector<std::pair<std::string, std::filesystem::path>> shipped_scenes();
/// The file that `name` means: itself where it exists, else <name>.toml among the scenes that ship (installed share folder, or the source
/// tree).
/// @throws InputError with the nearest name
std::filesystem::path find_scene(const std::string& name);
/// The same for a sweep (whorl tradeoff, whorl stability).
std::filesystem::path find_study(const std::string& name);

}  // namespace whorl
