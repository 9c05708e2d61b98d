#include <fmt/format.h>

#include <algorithm>
#include <cstdint>

#include "engine/scene/scene.h"
#include "tools/cost/estimate.h"
#include "tools/farm/stages.h"
#include "tools/film/first_pass.h"
#include "tools/film/panel_scenes.h"
#include "tools/process/process.h"
#include "tools/scene_file/camera_warnings.h"

namespace whorl {
namespace {

namespace fs = std::filesystem;

/// A task may take three times the predicted time and one and a half times the predicted memory, and some of both to begin.
constexpr double slack = 3, to_begin = 600, memory_slack = 1.5, memory_to_begin = 400e6;

std::string program() { return program_path().string(); }

FarmStage& stage_called(const std::string& name, std::vector<FarmStage>& stages) {
    const auto found = std::find_if(stages.begin(), stages.end(), [&](const FarmStage& s) { return s.name == name; });
    return found != stages.end() ? *found : stages.emplace_back(FarmStage{name, {}});
}

void add(FarmTask task, double seconds, double bytes, FarmStage& stage) {
    stage.tasks.push_back(std::move(task));
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

FarmFiles add_panels(const FarmFilm& film, const fs::path& folder, std::vector<FarmStage>& stages) {
    const Choose choose = [&](const SceneFile& run, const Simulation& start) { return with_first_pass(run, start, true); };
    const std::vector<SceneFile> runs = panel_scenes(film.file, film.file.scene.output.frames ? choose : Choose{});
    FarmFiles files{{folder / "scene.resolved.toml", resolved_toml(with_choices_of(film.file, runs))}};
    for (std::size_t k = 0; k < runs.size(); ++k) {
        const fs::path file = folder / "farm" / fmt::format("panel{}.toml", k + 1);
        files.emplace_back(file, resolved_toml(runs[k]));
        const Estimate e = estimate(runs[k]);
        add(run_task(fmt::format("panel {} of {}", k + 1, runs[k].scene.name), folder, file, folder / "panels" / std::to_string(k + 1),
                     film.threads, {}),
            e.film, e.memory, stage_called("panels", stages));
    }
    // If a panel diverged, the frames that it has are filmed.
    add({film.file.scene.name, {program(), "resume", folder.string(), "--quiet"}, folder, {}, {}, true}, 0.1 * frame_count(film.file.scene),
        200e6, stage_called("gather", stages));
    return files;
}

FarmFiles add_one(const FarmFilm& film, const fs::path& folder, std::vector<FarmStage>& stages) {
    const SceneFile& file = film.file;
    const fs::path scene = folder / "farm" / "scene.toml";
    const std::string text = resolved_toml(file), name = file.scene.name;
    const Estimate e = estimate(file);
    std::vector<std::string> later;
    if (file.scene.output.frames) later.emplace_back("--no-draw");
    add(run_task(name, folder, scene, folder, film.threads, later), e.film, e.memory, stage_called("simulate", stages));
    const int frames = frame_count(file.scene), most = film.pieces > 0 ? film.pieces : std::max(1, std::min(8, frames / 10));
    const int pieces = file.scene.output.frames ? std::min(most, frames) : 0;
    const auto frames_before = [&](int piece) { return static_cast<std::int64_t>(piece) * frames / pieces; };
    for (int k = 0; k < pieces; ++k) {
        const std::string range = fmt::format("{}-{}", 1 + frames_before(k), frames_before(k + 1));
        add({fmt::format("frames {} of {}", range, name),
             {program(), "draw", folder.string(), "--frames", range, "--no-video", "--quiet", "--threads", std::to_string(film.threads)},
             folder,
             {},
             {}},
            (e.surface + e.draw + e.write) * (frames / pieces + 1), e.memory, stage_called("draw", stages));
    }
    if (pieces > 0 && file.scene.output.video)
        add({name, {program(), "video", folder.string()}, folder, {}, {}}, 0.1 * frames, 200e6, stage_called("encode", stages));
    return {{folder / "scene.resolved.toml", text}, {scene, text}};
}

}  // namespace

FarmFiles add_film(const FarmFilm& film, std::vector<FarmStage>& stages) {
    make_plan(film.file);
    const fs::path path = fs::absolute(film.folder);
    return film.file.scene.panels.empty() ? add_one(film, path, stages) : add_panels(film, path, stages);
}

std::string remaining_commands(const FarmFilm& film, const std::string& stage) {
    const std::string folder = film.folder.string();
    if (stage == "draw") return "whorl draw " + folder;
    if (stage == "encode") return "whorl video " + folder;
    const bool drawn_later = stage == "simulate" && film.file.scene.output.frames;
    return fmt::format("whorl resume {0}{1}", folder, drawn_later ? fmt::format(" --no-draw, then whorl draw {}", folder) : "");
}

}  // namespace whorl
