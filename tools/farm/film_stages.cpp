#include "tools/farm/film_stages.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>

#include "engine/core/whole_file.h"
#include "engine/scene/frame_times.h"
#include "tools/cost/estimate.h"
#include "tools/film/first_pass.h"
#include "tools/film/panel_scenes.h"
#include "tools/film/run_folder.h"
#include "tools/process/process.h"
#include "tools/scene_file/camera_warnings.h"

namespace whorl {
namespace {

namespace fs = std::filesystem;

/// A task may take three times as long as foreseen and half as much memory again, and what it takes to begin.
constexpr double slack = 3, to_begin = 600, memory_slack = 1.5, memory_to_begin = 400e6;

std::string program() { return program_path().string(); }

void allow(FarmStage& stage, double seconds, double bytes) {
    stage.seconds = std::max(stage.seconds, slack * seconds + to_begin);
    stage.bytes = std::max(stage.bytes, memory_slack * bytes + memory_to_begin);
}

/// @param scene a file that holds the whole of it
FarmTask run_task(const std::string& name, const fs::path& film, const fs::path& scene, const fs::path& folder, int threads,
                  const std::vector<std::string>& more) {
    const std::vector<std::string> common{"--quiet", "--threads", std::to_string(threads)};
    FarmTask task{name,
                  {program(), "render", scene.string(), "--out", folder.string(), "--overwrite"},
                  film,
                  folder,
                  {program(), "resume", folder.string()}};
    for (std::vector<std::string>* words : {&task.command, &task.go_on}) {
        words->insert(words->end(), common.begin(), common.end());
        words->insert(words->end(), more.begin(), more.end());
    }
    return task;
}

FarmWork work_of_panels(const FarmFilm& film, const fs::path& folder) {
    const int frames = frame_count(film.file.scene);
    const Choose choose = [&](const SceneFile& run, const Simulation& start) { return with_first_pass(run, start, true); };
    const std::vector<SceneFile> runs = panel_scenes(film.file, film.file.scene.output.frames ? choose : Choose{});
    FarmWork work{{}, {{folder / "scene.resolved.toml", resolved_toml(with_choices_of(film.file, runs))}}};
    FarmStage panels{"panels", {}};
    for (std::size_t k = 0; k < runs.size(); ++k) {
        const SceneFile& run = runs[k];
        const fs::path file = folder / "farm" / fmt::format("panel{}.toml", k + 1);
        work.files.emplace_back(file, resolved_toml(run));
        panels.tasks.push_back(run_task(fmt::format("panel {} of {}", k + 1, run.scene.name), folder, file,
                                        folder / "panels" / std::to_string(k + 1), film.threads, {}));
        const Estimate e = estimate(run);
        allow(panels, e.film, e.memory);
    }
    // Of a panel that diverged the frames that it has are filmed.
    FarmStage gather{"gather", {{film.file.scene.name, {program(), "resume", folder.string(), "--quiet"}, folder, {}, {}, true}}};
    allow(gather, 0.1 * frames, 200e6);
    work.stages = {panels, gather};
    return work;
}

FarmWork work_of_one(const FarmFilm& film, const fs::path& folder) {
    const SceneFile& file = film.file;
    const fs::path scene = folder / "farm" / "scene.toml";
    const std::string text = resolved_toml(file);
    FarmWork work{{}, {{folder / "scene.resolved.toml", text}, {scene, text}}};
    const std::string name = file.scene.name;
    const Estimate e = estimate(file);
    if (!file.scene.output.frames) {
        FarmStage simulate{"simulate", {run_task(name, folder, scene, folder, film.threads, {})}};
        allow(simulate, e.film, e.memory);
        work.stages = {simulate};
        return work;
    }
    FarmStage simulate{"simulate", {run_task(name, folder, scene, folder, film.threads, {"--no-draw"})}}, draw{"draw", {}},
        encode{"encode", {}};
    allow(simulate, e.film, e.memory);
    const int frames = frame_count(file.scene), most = film.pieces > 0 ? film.pieces : std::max(1, std::min(8, frames / 10));
    const int pieces = std::min(most, frames);
    const auto frames_before = [&](int piece) { return static_cast<std::int64_t>(piece) * frames / pieces; };
    for (int k = 0; k < pieces; ++k) {
        const std::string range = fmt::format("{}-{}", 1 + frames_before(k), frames_before(k + 1));
        draw.tasks.push_back(
            {fmt::format("frames {} of {}", range, name),
             {program(), "draw", folder.string(), "--frames", range, "--no-video", "--quiet", "--threads", std::to_string(film.threads)},
             folder,
             {},
             {}});
    }
    allow(draw, (e.surface + e.draw + e.write) * (frames / pieces + 1), e.memory);
    encode.tasks.push_back({name, {program(), "video", folder.string()}, folder, {}, {}});
    allow(encode, 0.1 * frames, 200e6);
    work.stages = {simulate, draw};
    if (file.scene.output.video) work.stages.push_back(encode);
    return work;
}

}  // namespace

FarmWork work_of(const FarmFilm& film) {
    make_plan(film.file);
    const fs::path path = fs::absolute(film.folder);
    return film.file.scene.panels.empty() ? work_of_one(film, path) : work_of_panels(film, path);
}

FarmFolder begin(const FarmFilm& film, const FarmWork& work) {
    const fs::path path = fs::absolute(film.folder);
    const RunFolder folder = RunFolder::fresh(path);
    FarmFolder begun{folder.note(), RunFolder::any(path / "farm")};
    for (const auto& [file, text] : work.files) write_text(file, text);
    return begun;
}

std::string going_on(const FarmFilm& film, const std::string& stage) {
    const std::string folder = film.folder.string();
    if (stage == "draw") return "whorl draw " + folder;
    if (stage == "encode") return "whorl video " + folder;
    const bool drawn_later = stage == "simulate" && film.file.scene.output.frames;
    return fmt::format("whorl resume {0}{1}", folder, drawn_later ? fmt::format(" --no-draw, then whorl draw {}", folder) : "");
}

std::vector<FarmStage> together(const std::vector<std::vector<FarmStage>>& films) {
    std::vector<FarmStage> all;
    for (const std::vector<FarmStage>& film : films)
        for (const FarmStage& stage : film) {
            auto found = std::find_if(all.begin(), all.end(), [&](const FarmStage& s) { return s.name == stage.name; });
            if (found == all.end()) all.push_back({stage.name, {}}), found = all.end() - 1;
            found->tasks.insert(found->tasks.end(), stage.tasks.begin(), stage.tasks.end());
            found->seconds = std::max(found->seconds, stage.seconds), found->bytes = std::max(found->bytes, stage.bytes);
        }
    return all;
}

}  // namespace whorl
