#include "tools/program/sweep.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "engine/core/whole_file.h"
#include "tools/farm/stages.h"
#include "tools/film/progress.h"
#include "tools/film/run_folder.h"
#include "tools/process/json_text.h"
#include "tools/process/process.h"

namespace whorl {

namespace fs = std::filesystem;

void add_sweep_options(CLI::App& app, SweepOptions& o) {
    app.add_option("study", o.study, "study file, or the name of a study that ships")->required()->type_name("STUDY");
    app.add_option("--out", o.out, "folder of the results (default: out/<study name>)")->type_name("DIR")->check(not_empty);
    app.add_option("--on", o.on, "slurm: each run is a job of the Slurm that sbatch reaches; local: on this machine")
        ->capture_default_str()
        ->type_name("PLACE");
    app.add_option("--sbatch", o.sbatch, "one more option for sbatch: --sbatch=--partition=short (repeatable)")
        ->type_name("OPTION")
        ->allow_extra_args(false);
    app.add_option("--threads", o.threads, "threads of each run (default: local: what the runs at the same time leave each, slurm: 1)")
        ->type_name("N")
        ->check(whole_number(0, 1024));
    app.add_option("--jobs", o.jobs, "runs at the same time (default: local: as many as do not disturb what is measured, slurm: 8)")
        ->type_name("N")
        ->check(whole_number(0, 1024));
    app.add_option("--budget", o.budget, "stop after that much wall time: 90s, 10min, 1h")->type_name("TIME");
    app.add_flag("--json", o.json, "the result as JSON on standard output");
}

Sweep::Sweep(const Study& s, const SweepOptions& o, std::string of, fs::path into)
    : study(s), options(o), scene(std::move(of)), folder(std::move(into)), runner(s, folder, o.threads, {o.on == "slurm", o.sbatch}) {}

void Sweep::say(const std::string& text) const {
    if (!options.json) fmt::print("{}\n", text), std::fflush(stdout);
}

void Sweep::write(const std::string& name, const std::string& csv, const Canvas& canvas) const {
    write_text(folder / (name + ".csv"), csv);
    write_png(folder / (name + ".png"), canvas.image());
    write_text(folder / (name + ".svg"), canvas.svg());
}

void Sweep::print_json(const char* points_name, nlohmann::ordered_json points) const {
    if (options.json)
        fmt::print("{}\n", json_text({{"study", study.name}, {"scene", scene}, {"folder", folder.string()}, {points_name, points}}, 2));
}

int run_sweeps(const Study& study, SweepOptions o, bool timed, const std::function<void(const Sweep&)>& sweep) {
    seconds_of(o.budget);
    check_farm({.on = o.on, .sbatch = o.sbatch});
    constexpr int usual_jobs = 8;
    const int cores = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
    if (o.jobs == 0) o.jobs = o.on == "slurm" ? usual_jobs : timed ? 1 : o.threads > 0 ? std::max(1, cores / o.threads) : cores;
    if (o.threads == 0) o.threads = o.on == "slurm" ? 1 : std::max(1, cores / o.jobs);
    const fs::path folder = o.out.empty() ? fs::path("out") / study.name : o.out;
    const RunFolder held = RunFolder::any(folder);
    if (!held.note().empty()) tell_note(held.note(), o.json);
    try {
        for (const std::string& scene : study.scenes) {
            const fs::path own = study.scenes.size() == 1 ? folder : folder / fs::path(scene).stem();
            fs::create_directories(own);
            sweep(Sweep(study, o, scene, own));
        }
    } catch (const StudyInterrupted&) {
        fmt::print(stderr, "whorl: interrupted; points that are done are kept, the same command continues\n");
        return exit_interrupted;
    }
    return exit_done;
}

}  // namespace whorl
