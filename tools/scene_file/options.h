#pragma once
/// Options that several subcommands share.
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
    std::string scene;                         ///< a path, or the bare name of a shipped scene
    std::filesystem::path folder;              ///< run folder to continue, draw or encode
    std::vector<std::string> set;              ///< "key=value"
    std::vector<std::string> with;             ///< files whose keys override the scene's
    std::filesystem::path out;                 ///< empty: out/<scene name>
    std::optional<double> until;               ///< time.end [s]
    std::optional<int> frames;                 ///< number of the last frame (not a key of the scene)
    std::string size;                          ///< "1280x720"; output.size
    std::optional<double> fps;                 ///< time.fps
    std::string quality = "standard";          ///< draft | standard | fine: its [quality.*] table overrides the scene's keys
    bool no_video = false, no_images = false;  ///< output.video, output.images
    bool no_draw = false;                      ///< export raw frames, which whorl draw draws later
    std::vector<std::string> exports;          ///< output.export
    int threads = 0;                           ///< 0: all cores
    std::optional<std::uint64_t> seed;         ///< seed
    bool force = false;                        ///< resume even if input files were edited
    bool overwrite = false;                    ///< replace an existing run in the folder
    bool dry_run = false, quiet = false, json = false;
};

/// Validator for CLI11's check(): returns "" if the text is a valid number, otherwise an error message.
using NumberCheck = std::function<std::string(const std::string&)>;
NumberCheck whole_number(long long least, long long most = std::numeric_limits<int>::max());
NumberCheck any_number(const std::string& unit = "", bool above_zero = false);
/// Transformation for CLI11's transform(): converts "24000/1001" to a decimal number; returns other text unchanged.
std::string quotient(const std::string& text);

/// Validator for CLI11's check(): returns an error message if the text is empty, otherwise "".
std::string not_empty(const std::string& text);
/// Adds the options whose members `which` points to: {&o.scene, &o.set}. `options` must outlive the parsing.
void add_options(CLI::App& subcommand, Options& options, std::initializer_list<const void*> which);

}  // namespace whorl
