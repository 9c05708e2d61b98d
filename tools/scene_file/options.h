#pragma once
/// The options that several subcommands share.
#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace whorl {

struct Options {
    std::string scene;                         ///< a path, or the bare name of a scene that ships
    std::filesystem::path folder;              ///< of a run that is continued, drawn or encoded
    std::vector<std::string> set;              ///< "key=value"
    std::vector<std::string> with;             ///< files of a few keys that are laid over the scene
    std::filesystem::path out;                 ///< empty: out/<scene name>
    std::optional<double> until;               ///< s; time.end
    std::optional<int> frames;                 ///< stop after this many frames (render counts them; not a key of the scene)
    std::string size;                          ///< "1280x720"; output.size
    std::optional<double> fps;                 ///< time.fps
    std::string quality = "standard";          ///< draft | standard | fine: the [quality.*] table that is laid over the scene
    bool no_video = false, no_images = false;  ///< output.video, output.images
    bool no_draw = false;                      ///< the pictures are drawn later, from raw frames (whorl draw)
    std::vector<std::string> exports;          ///< output.export
    int threads = 0;                           ///< 0: all cores
    std::optional<std::uint64_t> seed;         ///< seed
    bool force = false;                        ///< resume with files that were edited since
    bool overwrite = false;                    ///< replace an existing run in the folder
    bool dry_run = false, quiet = false, json = false;
};

enum class Option {
    scene,
    folder,
    set,
    with,
    out,
    overwrite,
    force,
    until,
    frames,
    size,
    fps,
    quality,
    no_video,
    no_images,
    no_draw,
    exports,
    threads,
    seed,
    dry_run,
    quiet,
    json
};

/// For CLI11's check(): what the text of an option must be and is not; "" where it is such a number.
using NumberCheck = std::function<std::string(const std::string&)>;
NumberCheck whole_number(long long least, long long most = std::numeric_limits<int>::max());
NumberCheck any_number(const std::string& unit = "", bool above_zero = false);
/// For CLI11's transform(): "24000/1001" as a decimal number; any other text as it is.
std::string quotient(const std::string& text);

/// A check of CLI11's: what is wrong with an empty name, "" where it is none.
std::string not_empty(const std::string& text);
/// Adds those options to a subcommand; `options` must outlive the parsing (keep it in a shared_ptr that the callback holds).
void add_options(CLI::App& subcommand, Options& options, std::initializer_list<Option> which);

}  // namespace whorl
