#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>
#include <optional>

#include "engine/core/errors.h"
#include "render/video/encoder.h"
#include "tools/cost/choices.h"
#include "tools/cost/coarse_run.h"
#include "tools/film/contact_sheet.h"
#include "tools/film/film.h"
#include "tools/film/progress.h"
#include "tools/film/run.h"
#include "tools/film/run_folder.h"
#include "tools/scene_file/scene_changes.h"

namespace whorl {
namespace {

namespace fs = std::filesystem;

FilmOptions film_options(const RedrawRequest& request, bool whole) {
    const Scene& scene = request.file.scene;
    FilmOptions options{request.out, scene.name, scene.output, scene.time};
    if (!whole) options.output.video = false;
    // Some exports have a file for all frames, which a range must not replace.
    std::erase_if(options.output.exports, [&](const std::string& what) {
        const bool made = std::find(request.made.begin(), request.made.end(), what) != request.made.end();
        return what == "raw" ? request.out == request.run : !whole && made && (what == "scene" || what == "vtk");
    });
    return options;
}

/// Reuses meshes of the previous frame for solids of the same shape, so that their distance fields are not computed again.
void share_meshes(std::vector<FrameSolid>& solids, const std::vector<FrameSolid>& before) {
    for (std::size_t k = 0; k < std::min(solids.size(), before.size()); ++k)
        if (solids[k].mesh && before[k].mesh && solids[k].mesh->position == before[k].mesh->position &&
            solids[k].mesh->triangle == before[k].mesh->triangle)
            solids[k].mesh = before[k].mesh;
}

bool in_range(const RedrawRequest& request, int number) { return number >= request.first && (request.last == 0 || number <= request.last); }

/// CPU time of each stage per frame [s], as in "surface 0.24, draw 1.05".
std::string cpu_per_frame(const StageTimes& times) {
    std::string text;
    for (const auto& [stage, t] : times)
        if (t.calls > 0) text += fmt::format("{}{} {:.2f}", text.empty() ? "" : ", ", stage, t.cpu / static_cast<double>(t.calls));
    return text;
}

/// All images of a video have one size. @throws InputError if an existing image that is not drawn again has another size
void check_size_of_others(const RedrawRequest& request) {
    const std::array<int, 2>& size = request.file.scene.output.size;
    for (const int number : exported_frames(request.run)) {
        if (in_range(request, number) || !has_picture(request.out, number)) continue;
        Image other;
        try {
            other = read_picture(request.out, number);
        } catch (const std::exception&) { continue; }  // damaged: its size is unknown
        if (other.width == size[0] && other.height == size[1]) return;
        throw InputError({"--frames", 0, 0},
                         fmt::format("the other images in {} are {}x{}, but the new ones would be {}x{}", request.out.string(), other.width,
                                     other.height, size[0], size[1]),
                         "draw all frames, or choose another folder with --out");
    }
}

/// @throws InputError if the look draws foam and the frames have none
void check_foam(const SceneFile& file, const fs::path& run, const std::vector<int>& frames) {
    if (!(file.look.foam > 0) || shows_field(file.look) || frames.empty()) return;
    if (exported_frame(run, frames.front()).scalar.count("foam") > 0) return;
    throw InputError(file.scene.place("look.foam"), "look.foam: the frames of the run have no foam",
                     "render the scene again with look.foam, or set look.foam = 0");
}

/// Raw frames to draw. If the run is in progress: the existing frames, then each new one until the run ends.
class Exported {
public:
    /// @throws InputError if the range has no frames and the run will not export any
    explicit Exported(const RedrawRequest& request) : request_(request), over_(!request.goes_on) {
        all_ = exported_frames(request.run);
        if (!over_ && request.file.scene.exported("raw")) return;
        const std::string raw = (request.run / "raw").string();
        if (all_.empty()) throw InputError({raw, 0, 0}, "the run has no frames to draw from", "render the scene with --export raw");
        if (!ready().empty()) return;
        throw InputError({raw, 0, 0}, fmt::format("missing frames {} to {}", request.first, request.last > 0 ? request.last : all_.back()),
                         "", fmt::format("{} to {}", all_.front(), all_.back()));
    }
    const std::vector<int>& all() const { return all_; }
    /// Numbers of the existing frames in the range that next() has not returned.
    std::vector<int> ready() const {
        std::vector<int> numbers;
        for (const int n : all_)
            if (n > newest_ && in_range(request_, n)) numbers.push_back(n);
        return numbers;
    }
    /// Whether the range contains every frame of the run.
    bool whole() const {
        return over_ ? !all_.empty() && in_range(request_, all_.front()) && in_range(request_, all_.back())
                     : request_.first == 1 && request_.last == 0;
    }
    /// Waits for the next frame. @return its number; 0 if none is left @throws InputError if the run was resumed and draws the same images
    int next() {
        for (;;) {
            if (const std::vector<int> numbers = ready(); !numbers.empty()) return newest_ = numbers.front();
            if (over_ || (request_.last > 0 && newest_ >= request_.last)) return 0;
            held_.emplace(RunFolder::existing(request_.run, RunFolder::Hold::looking));  // waits two seconds if the run is in progress
            over_ = held_->is_held();
            if (!over_) check_images_free(request_.run, request_.out);
            all_ = exported_frames(request_.run);
        }
    }

private:
    const RedrawRequest& request_;
    bool over_;
    std::vector<int> all_;
    int newest_ = 0;  ///< last number that next() returned
    std::optional<RunFolder> held_;
};

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

SceneFile with_choices_from(SceneFile file, const fs::path& run, const std::vector<int>& frames) {
    constexpr int moments = 24;
    const int count = static_cast<int>(frames.size()), looked_at = std::min(count, moments);
    Seen seen(file.look);
    if (measures_range(file.look) || wants_extent(file))
        for (int n = 0; n < looked_at; ++n) seen.add(exported_frame(run, frames[n * (count - 1) / std::max(1, looked_at - 1)]));
    choose(file, seen.extent(), seen.size());
    if (!wants_range(file.look) && !wants_extent(file) && !wants_streak_time(file.look)) return file;
    try {
        return with_estimates(file, Simulation(file.scene, make_plan(file.scene)));
    } catch (const InputError&) {  // enough memory to draw, but not to simulate: each frame uses its own colour range
        return file;
    }
}

void check_images_free(const fs::path& run, const fs::path& out) {
    std::error_code none;
    if (!fs::equivalent(run, out, none) || !report_of(run).value("draws", true)) return;
    throw InputError({run.string(), 0, 0}, "the run is in progress and draws its own images here",
                     "draw into another folder, as in --out " + out.string() + "_drawn, or wait for its end");
}

int redraw(const RedrawRequest& request) {
    Exported frames(request);
    // The existing frames of an unfinished run do not show its end.
    const Scene& scene = request.file.scene;
    const SceneFile file = request.goes_on
                               ? with_choices(request.file, Simulation(scene, make_plan(scene)), watch_coarse_run(request.quiet))
                               : with_choices_from(request.file, request.run, frames.all());
    check_foam(file, request.run, frames.ready());
    Replay replay(file);
    const auto options_now = [&] {
        const SceneFile& now = replay.now();
        return std::make_shared<const PictureOptions>(PictureOptions{now.surface, now.camera, now.look});
    };
    const bool whole = frames.whole();
    const FilmOptions options = film_options(request, whole);
    if (!options.video().empty()) check_video(file.scene);
    std::optional<RunFolder> held;
    if (request.out != request.run)
        held.emplace(RunFolder::drawing(request.out, request.run, resolved_toml(file),
                                        whole ? RunFolder::Hold::alone : RunFolder::Hold::shared, request.overwrite));
    check_size_of_others(request);
    const std::vector<int> ready = frames.ready();
    const auto replaced = std::count_if(ready.begin(), ready.end(), [&](int n) { return has_picture(request.out, n); });
    if (replaced > 0 && !request.quiet) fmt::print(stderr, "existing images in {} are replaced: {}\n", request.out.string(), replaced);
    fs::create_directories(request.out / "frames");
    Film film(options);
    auto how = options_now();
    std::vector<FrameSolid> before;
    std::vector<fs::path> pictures;
    StatusLine line(request.quiet);
    while (const int number = frames.next()) {
        Frame frame = exported_frame(request.run, number);
        share_meshes(frame.solids, before);
        before = frame.solids;
        for (const auto& [k, look] : request.looks) frame.solids.at(k).appearance = look;
        if (replay.apply_until(frame.time, [](const Scene&, const Plan&, double) {})) how = options_now();
        film.add(std::move(frame), how, nullptr, false);
        pictures.push_back(picture_file(request.out, number, options.output.format));
        if (line.due()) line.show(fmt::format("{} of {} frames", film.frames_written(), pictures.size() + frames.ready().size()));
    }
    film.finish(!pictures.empty());
    if (whole && !pictures.empty()) write_contact_sheet(request.out, pictures);
    line.clear();
    if (!request.quiet && !pictures.empty()) fmt::print(stderr, "CPU seconds per frame: {}\n", cpu_per_frame(film.times()));
    if (!request.quiet)
        fmt::print(stderr, "{} drawn: {}\n", counted(static_cast<int>(pictures.size()), "frame"),
                   whole && !options.video().empty() ? options.video().string() : request.out.string());
    return exit_done;
}

}  // namespace whorl
