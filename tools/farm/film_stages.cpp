#include <fmt/format.h>

#include <algorithm>
#include <cstdint>

#include "engine/scene/scene.h"
#include "tools/cost/coarse_run.h"
#include "tools/farm/stages.h"
#include "tools/film/panel_scenes.h"
#include "tools/process/process.h"

namespace whorl {
namespace {

namespace fs = std::filesystem;

/// Limits of a task: 3 times the predicted time and 1.5 times the predicted memory, plus 600 s and 400 MB to start.
constexpr double slack = 3, to_begin = 600, memory_slack = 1.5, memory_to_begin = 400e6;

std::string program() { return program_path().string(); }

void add(FarmTask task, double seconds, double bytes, FarmStage& stage) {
    stage.tasks.push_back(std::move(task));
    stage.seconds = std::max(stage.seconds, slack * seconds + to_begin);
    stage.bytes = std::max(stage.bytes, memory_slack * bytes + memory_to_begin);
}

/// Task that makes a run. @param scene file of the resolved scene
FarmTask run_task(const std::string& name, const fs::path& scene, const fs::path& folder, const std::string& threads,
                  const std::vector<std::string>& more) {
    FarmTask task{name,
                  {program(), "render", scene.string(), "--out", folder.string(), "--overwrite"},
                  folder,
                  {program(), "resume", folder.string()}};
    for (std::vector<std::string>* words : {&task.command, &task.resume}) {
        words->insert(words->end(), {"--quiet", "--threads", threads});
        words->insert(words->end(), more.begin(), more.end());
    }
    return task;
}

void add_panels(const std::string& threads, FarmFilm& film) {
    const Choose choose = [&](const SceneFile& run, const Simulation& start) { return with_choices(run, start); };
    const std::vector<SceneFile> runs = panel_scenes(film.file, film.file.scene.output.images ? choose : Choose{});
    film.files.emplace_back(film.folder / "scene.resolved.toml", resolved_toml(with_choices_of(film.file, runs)));
    FarmStage panels{"panels", {}};
    for (std::size_t k = 0; k < runs.size(); ++k) {
        const fs::path file = film.folder / "farm" / fmt::format("panel{}.toml", k + 1);
        film.files.emplace_back(file, resolved_toml(runs[k]));
        const Estimate e = estimate(runs[k]);
        add(run_task(fmt::format("panel {} of {}", k + 1, runs[k].scene.name), file, film.folder / "panels" / std::to_string(k + 1),
                     threads, {}),
            e.film, e.memory, panels);
    }
    // If a panel diverged, the video shows the frames that exist.
    FarmStage gather{"gather", {}};
    gather.after_failures = true;
    add({film.file.scene.name, {program(), "resume", film.folder.string(), "--quiet", "--threads", threads}, {}, {}},
        0.1 * frame_count(film.file.scene), 200e6, gather);
    film.stages = {panels, gather};
}

void add_one(const std::string& threads, int most_pieces, FarmFilm& film) {
    const fs::path scene = film.folder / "farm" / "scene.toml";
    const std::string text = resolved_toml(film.file), name = film.file.scene.name, folder = film.folder.string();
    const OutputKeys& output = film.file.scene.output;
    const Estimate e = estimate(film.file);
    film.files = {{film.folder / "scene.resolved.toml", text}, {scene, text}};
    FarmStage simulate{"simulate", {}}, draw{"draw", {}}, encode{"encode", {}};
    add(run_task(name, scene, film.folder, threads, output.images ? std::vector<std::string>{"--no-draw"} : std::vector<std::string>{}),
        e.film, e.memory, simulate);
    film.stages = {simulate};
    if (!output.images) return;
    const int frames = frame_count(film.file.scene);
    const int pieces = std::min(frames, most_pieces > 0 ? most_pieces : std::max(1, std::min(8, frames / 10)));
    const auto frames_before = [&](int piece) { return static_cast<std::int64_t>(piece) * frames / pieces; };
    for (int k = 0; k < pieces; ++k) {
        const std::string range = fmt::format("{}-{}", 1 + frames_before(k), frames_before(k + 1));
        add({fmt::format("frames {} of {}", range, name),
             {program(), "draw", folder, "--frames", range, "--no-video", "--quiet", "--threads", threads},
             {},
             {}},
            (e.surface + e.draw + e.write) * (frames / pieces + 1), e.memory, draw);
    }
    film.stages.push_back(draw);
    add({name, {program(), "video", folder}, {}, {}}, 0.1 * frames, 200e6, encode);
    if (output.video) film.stages.push_back(encode);
}

}  // namespace

FarmFilm farm_film(const SceneFile& file, const fs::path& folder, const FarmOptions& options) {
    make_plan(file);
    FarmFilm film{file, fs::absolute(folder), {}, {}};
    const std::string threads = std::to_string(options.threads);
    file.scene.panels.empty() ? add_one(threads, options.pieces, film) : add_panels(threads, film);
    return film;
}

std::string remaining_commands(const SceneFile& file, const fs::path& folder, const std::string& stage) {
    if (stage == "draw") return "whorl draw " + folder.string();
    if (stage == "encode") return "whorl video " + folder.string();
    const bool drawn_later = stage == "simulate" && file.scene.output.images;
    return fmt::format("whorl resume {0}{1}", folder.string(),
                       drawn_later ? fmt::format(" --no-draw, then whorl draw {}", folder.string()) : "");
}

}  // namespace whorl
