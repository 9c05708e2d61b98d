#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "engine/core/errors.h"
#include "engine/core/parallel.h"
#include "engine/core/whole_file.h"
#include "engine/scene/document.h"
#include "render/video/encoder.h"
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

struct FarmCommand {
    Options shared;
    FarmOptions farm;
    std::vector<std::string> scenes;
    int pieces = 0;
};

/// Whether the name is a study's. A scene of that name comes first.
bool is_study(const std::string& name) {
    for (fs::path (*const find)(const std::string&) : {find_scene, find_study}) try {
            return parse_toml_file(find(name).string()).find("knob") != nullptr;
        } catch (const InputError&) {}  // told where it is read
    return false;
}

/// A study's runs are jobs of their own, as its own commands have them: of tradeoff where it says what accuracy is, else of stability.
int farm_study(const FarmCommand& command) {
    const Options& o = command.shared;
    const std::string& name = command.scenes.front();
    if (command.scenes.size() > 1) throw InputError({name, 0, 0}, "is a study, which is farmed alone", "leave the other names out");
    if (!o.set.empty() || !o.with.empty() || o.until || !o.size.empty() || o.fps || o.quality != Options().quality || o.no_video ||
        o.no_images || !o.exports.empty() || o.seed || o.quiet || command.pieces > 0)
        throw InputError({name, 0, 0}, "is a study, whose own file says what its runs are", "",
                         "options with a study: --on, --jobs, --threads, --sbatch, --out");
    SweepOptions sweep;
    sweep.study = name, sweep.out = o.out, sweep.threads = o.threads, sweep.jobs = command.farm.jobs;
    sweep.on = command.farm.on, sweep.sbatch = command.farm.sbatch;
    return parse_toml_file(find_study(name).string()).find("accuracy") ? run_tradeoff(sweep) : run_stability(sweep);
}

int farm(FarmCommand command) {
    check_farm(command.farm);
    for (const std::string& scene : command.scenes)
        if (is_study(scene)) {
            std::swap(command.scenes.front(), *std::find(command.scenes.begin(), command.scenes.end(), scene));
            return farm_study(command);
        }
    command.farm.threads = command.shared.threads, command.farm.quiet = command.shared.quiet;
    std::vector<FarmFilm> films;
    for (const std::string& scene : command.scenes) {
        Options own = command.shared;
        own.scene = scene;
        FarmFilm film{read_scene_file(own), {}, command.pieces, 1};
        const std::string name = film.file.scene.name;
        film.folder = own.out.empty() ? fs::path("out") / name : command.scenes.size() == 1 ? own.out : own.out / name;
        for (const FarmFilm& other : films)
            if (other.folder == film.folder)
                throw InputError({scene, 0, 0}, "two of the films have the name " + name, "give one of them another name");
        RunFolder::check_fresh(film.folder);  // of all of them, before one is touched
        films.push_back(std::move(film));
    }
    const auto wants_video = [](const FarmFilm& film) { return film.file.scene.output.frames && film.file.scene.output.video; };
    for (const FarmFilm& film : films)
        if (wants_video(film)) check_video_rate(film.file.scene);
    if (command.farm.on == "local" && std::any_of(films.begin(), films.end(), wants_video)) check_encoder(without_video(false));
    share_cores(command.farm, films.size() == 1 ? 2 : films.size());
    set_threads(command.farm.threads);  // what the tasks have: the limits of time go by it
    std::vector<FarmStage> stages;
    std::vector<FarmFiles> files;
    for (FarmFilm& film : films) {  // an impossible scene ends here, before anything is written
        film.threads = command.farm.threads;
        // Its tasks run quietly.
        const std::string whose = films.size() > 1 ? film.file.scene.name + ": " : "";
        if (!command.farm.quiet)
            for (const std::string& warning : warnings_of(film.file)) fmt::print(stderr, "warning: {}{}\n", whose, warning);
        files.push_back(add_film(film, stages));
    }
    std::vector<RunFolder> held;  // no other farm begins in these folders meanwhile; the tasks hold the runs themselves
    for (std::size_t k = 0; k < films.size(); ++k) {
        const fs::path path = fs::absolute(films[k].folder);
        const std::string note = RunFolder::fresh(path).note();
        if (!note.empty()) tell_note(note, false);
        held.push_back(RunFolder::any(path / "farm"));
        for (const auto& [file, text] : files[k]) write_text(file, text);
    }
    const InterruptGuard interrupt;
    const FarmEnd end = run_stages(stages, films.front().folder / "farm", command.farm, interrupt);
    for (const FarmFilm& film : films)
        if (const auto at = end.stopped.find(fs::absolute(film.folder)); at != end.stopped.end())
            fmt::print(stderr, "whorl: {} was interrupted; go on with: {}\n", film.file.scene.name, remaining_commands(film, at->second));
    for (const FarmFilm& film : films)
        if (!end.interrupted && std::none_of(end.failures.begin(), end.failures.end(),
                                             [&](const FarmFailure& failure) { return failure.film == fs::absolute(film.folder); }))
            fmt::print("{}\n", film.folder.string());
    std::fflush(stdout);
    for (const FarmFailure& failure : end.failures) fmt::print(stderr, "whorl: {}\n", failure.message);
    if (end.interrupted) return exit_interrupted;
    return end.failures.empty() ? exit_done : exit_failed;
}

}  // namespace

void add_farm(CLI::App& program, Job& chosen) {
    const auto command = std::make_shared<FarmCommand>();
    CLI::App* app =
        program.add_subcommand("farm", "make films on several machines: the runs of panels, or the pictures of one run, as jobs");
    app->add_option("scenes", command->scenes, "scene files, or names of scenes that ship; or one study")->required()->type_name("SCENE");
    app->add_option("--on", command->farm.on, "slurm: as job arrays of the Slurm that sbatch reaches; local: on this machine")
        ->capture_default_str()
        ->type_name("PLACE");
    app->add_option("--jobs", command->farm.jobs, "tasks at the same time (default: local: as the cores carry, slurm: no limit)")
        ->type_name("N")
        ->check(whole_number(1));
    app->add_option("--pieces", command->pieces, "pieces that a film is drawn in (default: 8, or fewer of ten frames each)")
        ->type_name("N")
        ->check(whole_number(1));
    app->add_option("--sbatch", command->farm.sbatch, "one more option for sbatch: --sbatch=--partition=short (repeatable)")
        ->type_name("OPTION")
        ->allow_extra_args(false);
    add_options(*app, command->shared,
                {Option::set, Option::with, Option::out, Option::until, Option::size, Option::fps, Option::quality, Option::no_video,
                 Option::no_images, Option::exports, Option::threads, Option::seed, Option::quiet});
    app->get_option("--out")->description("run folder (default: out/<scene name>); of several scenes, the folder that theirs stand in");
    app->footer(
        "A film of panels: a job for each panel, and one that puts them side by side. Any other film: one job simulates and keeps its "
        "frames,\n"
        "others draw ranges of them, a last one encodes. Limits of time and memory come from the plan. A job whose machine fails is begun "
        "again\n"
        "and goes on from its checkpoint. A film that fails leaves the others. The folder of the run must be one that all machines see.\n"
        "Of a study, each run is a job, as with whorl tradeoff STUDY --on slurm (or stability).\n"
        "Examples:\n"
        "  whorl farm towed_post --on slurm --threads 8\n"
        "  whorl farm honey_coil lava dam_break --on slurm --sbatch=--partition=short --out runs\n"
        "  whorl farm spin_up --on local --jobs 2");
    app->callback([command, &chosen] { chosen = [command] { return farm(*command); }; });
}

}  // namespace whorl
