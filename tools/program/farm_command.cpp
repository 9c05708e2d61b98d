#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "engine/core/errors.h"
#include "tools/farm/film_stages.h"
#include "tools/process/interrupt.h"
#include "tools/program/command.h"

namespace whorl {
namespace {

namespace fs = std::filesystem;

struct FarmCommand {
    Options shared;
    FarmOptions farm;
    std::vector<std::string> scenes;
    int pieces = 0;
};

int farm(FarmCommand command) {
    check_farm(command.farm);
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
        films.push_back(std::move(film));
    }
    share_cores(command.farm, films.size() == 1 ? 2 : films.size());
    std::vector<std::vector<FarmStage>> all;
    for (FarmFilm& film : films) {
        film.threads = command.farm.threads;
        std::string note;
        all.push_back(stages_of(film, note));
        if (!note.empty() && !command.farm.quiet) fmt::print(stderr, "{}\n", note);
    }
    const InterruptGuard interrupt;
    if (!run_stages(together(all), films.front().folder / "farm", command.farm, interrupt)) return exit_interrupted;
    for (const FarmFilm& film : films) fmt::print("{}\n", film.folder.string());
    return exit_done;
}

}  // namespace

void add_farm(CLI::App& program, Job& chosen) {
    const auto command = std::make_shared<FarmCommand>();
    CLI::App* app =
        program.add_subcommand("farm", "make films on several machines: the runs of panels, or the pictures of one run, as jobs");
    app->add_option("scenes", command->scenes, "scene files, or names of scenes that ship")->required()->type_name("SCENE");
    app->add_option("--on", command->farm.on, "slurm: as job arrays of the Slurm that sbatch reaches; local: on this machine")
        ->capture_default_str()
        ->type_name("PLACE");
    app->add_option("--jobs", command->farm.jobs, "tasks at the same time (default: local: as the cores carry, slurm: no limit)")
        ->type_name("N")
        ->check(CLI::PositiveNumber);
    app->add_option("--pieces", command->pieces, "pieces that a film is drawn in (default: 8)")->type_name("N")->check(CLI::PositiveNumber);
    app->add_option("--sbatch", command->farm.sbatch, "one more option for sbatch: --sbatch=--partition=short (repeatable)")
        ->type_name("OPTION")
        ->allow_extra_args(false);
    add_options(*app, command->shared,
                {Option::set, Option::with, Option::out, Option::until, Option::size, Option::fps, Option::quality, Option::no_video,
                 Option::no_images, Option::exports, Option::threads, Option::seed, Option::quiet});
    app->footer(
        "A film of panels: a job for each panel, and one that puts them side by side. Any other film: one job simulates and keeps its "
        "frames,\n"
        "others draw ranges of them, a last one encodes. Limits of time and memory come from the plan. A job whose machine fails is begun "
        "again\n"
        "and goes on from its checkpoint. The folder of the run must be one that all machines see.\n"
        "Examples:\n"
        "  whorl farm towed_post --on slurm --threads 8\n"
        "  whorl farm honey_coil lava dam_break --on slurm --sbatch=--partition=short --out runs\n"
        "  whorl farm spin_up --on local --jobs 2");
    app->callback([command, &chosen] { chosen = [command] { return farm(*command); }; });
}

}  // namespace whorl
