#include <fmt/format.h>

#include <algorithm>
#include <thread>

#include "engine/core/atomic_file.h"
#include "engine/core/errors.h"
#include "engine/core/parallel.h"
#include "tools/farm/stages.h"
#include "tools/film/panel_scenes.h"
#include "tools/film/progress.h"
#include "tools/film/run.h"
#include "tools/film/run_folder.h"
#include "tools/process/process.h"
#include "tools/program/command.h"
#include "tools/program/sweep.h"

namespace whorl {
namespace {

namespace fs = std::filesystem;

struct FarmCommand : Options {
    FarmOptions farm;
    std::vector<std::string> scenes;
};

int farm(const FarmCommand& o) {
    FarmOptions options = o.farm;
    check_farm(options);
    const bool here = options.on == "local";
    options.threads = o.threads > 0 ? o.threads : here ? static_cast<int>(std::max(1U, std::thread::hardware_concurrency())) : 1;
    options.quiet = o.quiet;
    set_threads(options.threads);  // predicted times, and so the time limits of jobs, depend on it
    std::vector<SceneFile> files;
    std::vector<fs::path> folders;  // as they are printed in messages
    for (const std::string& scene : o.scenes) {
        Options own = o;
        own.scene = scene;
        files.push_back(read_scene_file(own));
        const std::string name = files.back().scene.name;
        fs::path folder = o.out.empty() ? fs::path("out") / name : o.scenes.size() == 1 ? o.out : o.out / name;
        if (std::find(folders.begin(), folders.end(), folder) != folders.end())
            throw InputError({scene, 0, 0}, "two of the scenes have the name " + name, "rename one of them");
        RunFolder::check_fresh(folder, o.overwrite);  // check all folders before any of them is changed
        folders.push_back(std::move(folder));
    }
    const auto wants_video = [](const SceneFile& file) { return file.scene.output.images && file.scene.output.video; };
    for (const SceneFile& file : files)
        if (wants_video(file)) check_video(file.scene, here);
    std::vector<FarmFilm> films;
    for (std::size_t k = 0; k < files.size(); ++k) {  // throws for an impossible scene, before anything is written
        // Warnings are printed here, because the tasks are quiet.
        const std::string whose = files.size() > 1 ? files[k].scene.name + ": " : "";
        if (!options.quiet)
            for (const std::string& warning : warnings_of(files[k])) fmt::print(stderr, "warning: {}{}\n", whose, warning);
        films.push_back(farm_film(files[k], folders[k], options));
    }
    std::vector<RunFolder> held;  // keep other farms out of these folders; the tasks themselves hold the run folders
    for (const FarmFilm& film : films) {
        RunFolder::fresh(film.folder, o.overwrite);
        held.push_back(RunFolder::any(film.folder / "farm"));
        for (const auto& [file, text] : film.files) write_text(file, text);
    }
    const InterruptGuard interrupt;
    const std::vector<FarmEnd> ends = make_films(films, options, interrupt);
    const bool stopped = std::any_of(ends.begin(), ends.end(), [](const FarmEnd& end) { return !end.stopped.empty(); });
    int code = ends.empty() || stopped ? exit_interrupted : exit_done;
    for (std::size_t k = 0; k < ends.size(); ++k) {
        for (const std::string& failure : ends[k].failures) fmt::print(stderr, "whorl: {}\n", failure);
        if (!ends[k].stopped.empty())
            fmt::print(stderr, "whorl: {} was interrupted; continue with: {}\n", files[k].scene.name,
                       remaining_commands(files[k], folders[k], ends[k].stopped));
        else if (ends[k].failures.empty()) fmt::print("{}\n", folders[k].string());
        if (code == exit_done && !ends[k].failures.empty()) code = exit_failed;
    }
    return code;
}

}  // namespace

void add_farm(CLI::App& program, Job& chosen) {
    const auto [app, o] = add_command(
        program, chosen, "farm", "render scenes as jobs on several machines: one job per panel, or per range of frames", farm,
        "A scene with panels has a job per panel, and a last job that puts them side by side. For any other scene, one job simulates and "
        "exports\n"
        "frames, several draw ranges of them, and a last one encodes the video. Limits of time and memory come from the plan. A job whose "
        "machine\n"
        "fails is restarted and continues from its checkpoint. A scene that fails does not stop the others. All machines must see the run "
        "folder.\n"
        "Examples:\n"
        "  whorl farm towed_post --on slurm --threads 8\n"
        "  whorl farm honey_coil lava dam_break --on slurm --sbatch=--partition=short --out runs\n"
        "  whorl farm spin_up --on local");
    app.add_option("scenes", o.scenes, "scene files, or names of shipped scenes")->required()->type_name("SCENE");
    add_slurm_options(app, o.farm.on, o.farm.sbatch);
    app.add_option("--jobs", o.farm.jobs, "slurm: most tasks of a stage at the same time (default: no limit)")
        ->type_name("N")
        ->check(whole_number(1));
    app.add_option("--pieces", o.farm.pieces,
                   "number of ranges that the frames are drawn in (default: 8, or fewer with at least ten frames each)")
        ->type_name("N")
        ->check(whole_number(1));
    add_options(app, o,
                {&o.set, &o.with, &o.out, &o.overwrite, &o.until, &o.size, &o.fps, &o.quality, &o.no_video, &o.no_images, &o.exports,
                 &o.threads, &o.seed, &o.quiet});
    app.get_option("--out")->description(
        "run folder (default: out/<scene name>); for several scenes, the folder that contains their run folders");
}

}  // namespace whorl
