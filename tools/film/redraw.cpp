
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>

#include "engine/core/errors.h"
#include "render/video/encoder.h"
#include "tools/film/contact_sheet.h"
#include "tools/film/film.h"
#include "tools/film/first_pass.h"
#include "tools/film/progress.h"
#include "tools/film/run.h"
#include "tools/film/run_folder.h"
#include "tools/process/process.h"
#include "tools/scene_file/scene_changes.h"

namespace whorl {
namespace {

namespace fs = std::filesystem;

FilmOptions film_options(const RedrawRequest& request, bool whole) {
    const Scene& scene = request.file.scene;
    FilmOptions options;
    options.folder = request.out, options.name = scene.name, options.format = scene.output.format;
    if (whole && scene.output.video) options.video = request.out / (scene.name + ".mp4");
    // Some exports have a file of the whole film, which a range must not replace.
    const auto keeps = [&](const std::string& what) {
        return (what == "scene" || what == "vtk") && std::find(request.made.begin(), request.made.end(), what) != request.made.end();
    };
    for (const std::string& what : scene.output.exports)
        if (what == "raw" ? request.out != request.run : whole || !keeps(what)) options.exports.push_back(what);
    options.width = scene.output.size[0], options.height = scene.output.size[1];
    options.fps = scene.time.fps, options.interval = scene.time.frame_interval();
    return options;
}

/// Solids keep their shape: one that the frame before has, too, is the same mesh, whose distance field is known.
void share_meshes(std::vector<FrameSolid>& solids, const std::vector<FrameSolid>& before) {
    for (std::size_t k = 0; k < std::min(solids.size(), before.size()); ++k)
        if (solids[k].mesh && before[k].mesh && solids[k].mesh->position == before[k].mesh->position &&
            solids[k].mesh->triangle == before[k].mesh->triangle)
            solids[k].mesh = before[k].mesh;
}

/// Pictures of one film have one size. @param numbers of those that are drawn @throws InputError where those that stay have another
void check_size_of_others(const RedrawRequest& request, const std::vector<int>& numbers) {
    const std::array<int, 2>& size = request.file.scene.output.size;
    for (const int number : exported_frames(request.run)) {
        if (std::binary_search(numbers.begin(), numbers.end(), number) || !has_picture(request.out, number)) continue;
        Image other;
        try {
            other = read_picture(request.out, number);
        } catch (const std::exception&) { continue; }  // damaged: it is no measure
        if (other.width == size[0] && other.height == size[1]) return;
        throw InputError({"--frames", 0, 0},
                         fmt::format("the other pictures in {} are {}x{}, and these would be {}x{}", request.out.string(), other.width,
                                     other.height, size[0], size[1]),
                         "draw all frames, or into another folder with --out");
    }
}

}  // namespace

std::vector<int> exported_frames(const fs::path& run_folder) {
    std::vector<int> numbers;
    std::error_code none;
    for (const auto& entry : fs::directory_iterator(run_folder / "raw", none)) {
        if (entry.path().extension() != ".frame") continue;
        const std::string name = entry.path().stem().string();
        int number = 0;
        const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), number);
        if (error == std::errc() && end == name.data() + name.size() && number > 0) numbers.push_back(number);
    }
    std::sort(numbers.begin(), numbers.end());
    return numbers;
}

int redraw(const RedrawRequest& request) {
    std::vector<int> numbers = exported_frames(request.run);
    if (numbers.empty())
        throw InputError({(request.run / "raw").string(), 0, 0}, "there are no frames to draw from", "render the scene with --export raw");
    const int all = static_cast<int>(numbers.size()), last = request.last > 0 ? request.last : numbers.back();
    const std::vector<int> exported = numbers;
    std::erase_if(numbers, [&](int n) { return n < request.first || n > last; });
    if (numbers.empty())
        throw InputError(
            {(request.run / "raw").string(), 0, 0}, fmt::format("there are no frames {} to {}", request.first, last), "",
            fmt::format("{} to {}{}", exported.front(), exported.back(), exported.back() - exported.front() < all ? "" : ", with gaps"));
    const bool whole = static_cast<int>(numbers.size()) == all;
    const SceneFile file = with_choices_from(request.file, request.run, exported);
    Replay replay(file);
    const auto options_now = [&] {
        const SceneFile& now = replay.now();
        return std::make_shared<const PictureOptions>(PictureOptions{now.surface, now.camera, now.look});
    };
    const FilmOptions options = film_options(request, whole);
    if (!options.video.empty()) check_video_rate(file.scene), check_encoder(without_video(false));
    std::optional<RunFolder> held;
    if (request.out != request.run) {
        held.emplace(
            RunFolder::drawing(request.out, request.run, resolved_toml(file), whole ? RunFolder::Hold::alone : RunFolder::Hold::shared));
        if (!held->note().empty()) tell_note(held->note(), false);
    }
    if (!whole) check_size_of_others(request, numbers);
    const auto replaced = std::count_if(numbers.begin(), numbers.end(), [&](int n) { return has_picture(request.out, n); });
    if (replaced > 0 && !request.quiet) fmt::print(stderr, "pictures that stand in {} are replaced: {}\n", request.out.string(), replaced);
    fs::create_directories(request.out / "frames");
    Film film(options);
    auto how = options_now();
    std::vector<FrameSolid> before;
    for (const int number : numbers) {
        Frame frame = exported_frame(request.run, number);
        share_meshes(frame.solids, before);
        before = frame.solids;
        if (replay.apply_until(frame.time, [](const Scene&, const Plan&, double) {})) how = options_now();
        film.add(std::move(frame), how, nullptr, false);
        if (!request.quiet) fmt::print(stderr, "\r{} of {} frames ", film.frames_written(), numbers.size()), std::fflush(stderr);
    }
    film.finish(true);
    if (whole) {
        std::vector<fs::path> pictures;
        for (const int number : numbers) pictures.push_back(picture_file(request.out, number, options.format));
        write_contact_sheet(request.out, pictures);
    }
    if (!request.quiet)
        fmt::print(stderr, "\r{} drawn: {}\n", counted(static_cast<int>(numbers.size()), "frame"),
                   whole && !options.video.empty() ? options.video.string() : request.out.string());
    return exit_done;
}

}  // namespace whorl
