#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "engine/core/errors.h"
#include "render/video/encoder.h"
#include "tools/film/contact_sheet.h"
#include "tools/film/run_folder.h"
#include "tools/program/command.h"
#include "tools/scene_file/options.h"
#include "tools/scene_file/scene_file.h"

namespace whorl {
namespace {

struct EncodeOptions : Options {
    int crf = 18;
};

/// Encodes every image of frames/, in the order of their names.
int encode(const EncodeOptions& options) {
    const std::filesystem::path &folder = options.folder, &out = options.out;
    const std::optional<double> given_fps = options.fps;
    const RunFolder held = RunFolder::existing(folder, out.empty() ? RunFolder::Hold::alone : RunFolder::Hold::shared);
    const std::filesystem::path frames = folder / "frames", scene_file = folder / "scene.resolved.toml";
    std::map<std::filesystem::path, std::filesystem::path> pictures;  // images by file name without suffix
    std::error_code missing;
    for (const auto& entry : std::filesystem::directory_iterator(frames, missing))
        if ((entry.path().extension() == ".png" || entry.path().extension() == ".exr") && entry.path().stem().extension().empty())
            pictures[entry.path().stem()] = entry.path();
    if (pictures.empty())
        throw InputError({frames.string(), 0, 0}, "no images to encode", "give a run folder that has images, as in out/honey_coil");

    const Scene scene = read_scene_file(scene_file).scene;
    const std::filesystem::path video = out.empty() ? folder / (scene.name + ".mp4") : out;
    const auto& known = video_suffixes();
    if (std::find(known.begin(), known.end(), video.extension().string()) == known.end())
        throw InputError({"--out", 0, 0}, "\"" + video.string() + "\" is not the name of a supported video file", "",
                         fmt::format("allowed suffixes: {}", fmt::join(known, ", ")));
    if (const std::filesystem::path parent = video.parent_path(); !parent.empty() && !std::filesystem::is_directory(parent))
        throw InputError({"--out", 0, 0}, "folder not found: \"" + parent.string() + "\"", "create it first");
    const double fps = given_fps.value_or(scene.time.fps);
    if (fps < least_video_fps)
        throw InputError(given_fps ? FileLocation{"--fps", 0, 0} : scene.place("time.fps"),
                         fmt::format("{:g} frames per second are too few for a video", fps),
                         given_fps ? "" : "set a higher rate with --fps", fmt::format("allowed: at least {:g}", least_video_fps));
    check_encoder();
    const Image first = read_picture(pictures.begin()->second);
    if (first.width < 2 || first.height < 2)
        throw InputError({pictures.begin()->second.string(), 0, 0}, fmt::format("is {}x{}", first.width, first.height), "",
                         "a video needs at least 2x2 pixels");
    const bool alpha = !first.alpha.empty();
    if (alpha && !video_has_alpha(video))
        fmt::print(stderr, "{} has no alpha: the images are drawn over grey (.mov and .webm keep alpha)\n", video.extension().string());
    VideoEncoder encoder(video, first.width, first.height, {fps, options.crf, alpha});
    for (const auto& [name, picture] : pictures) {
        const Image image = read_picture(picture);
        if (image.width != first.width || image.height != first.height)
            throw InputError({picture.string(), 0, 0},
                             fmt::format("is {}x{}, but earlier images are {}x{}", image.width, image.height, first.width, first.height));
        encoder.add(image);
    }
    encoder.finish();
    if (const std::size_t planned = report_of(folder).value("frames_planned", std::size_t{0}); pictures.size() < planned)
        fmt::print(stderr, "the run has images of {} of its {} frames; the video contains only these\n", pictures.size(), planned);
    if (out.empty()) {
        std::vector<std::filesystem::path> files;
        for (const auto& [name, picture] : pictures) files.push_back(picture);
        write_contact_sheet(folder, files);
    }
    fmt::print("{}\n", video.string());
    return exit_done;
}

}  // namespace

void add_video(CLI::App& program, Job& chosen) {
    const auto [app, o] =
        add_command(program, chosen, "video", "encode a run's video again from its images", encode,
                    "Example:\n  whorl video out/honey_coil --fps 60 --crf 12\n  whorl video out/honey_coil --out honey.gif");
    add_options(app, o, {&o.folder, &o.fps, &o.out});
    app.get_option("--fps")->check(any_number("", true));
    app.add_option("--crf", o.crf, "quality of H.264 and VP9, 0 to 51; a lower value gives a better and larger video")
        ->capture_default_str()
        ->check(whole_number(0, 51));
    app.get_option("--out")->type_name("FILE")->description(
        "name of the video, ending in .mp4, .mov (ProRes), .webm or .gif (default: <scene>.mp4 in the run folder); .mov and .webm keep "
        "alpha");
}

}  // namespace whorl
