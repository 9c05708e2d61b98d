#include "tools/program/sweep.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <future>
#include <limits>
#include <thread>

#include "engine/core/atomic_file.h"
#include "engine/core/clock.h"
#include "engine/io/csv.h"
#include "tools/farm/stages.h"
#include "tools/film/progress.h"
#include "tools/film/run_folder.h"
#include "tools/process/json_text.h"

namespace whorl {

namespace fs = std::filesystem;

void add_slurm_options(CLI::App& app, std::string& on, std::vector<std::string>& sbatch) {
    app.add_option("--on", on, "slurm: run as Slurm jobs, submitted with sbatch; local: run on this machine")
        ->capture_default_str()
        ->type_name("PLACE");
    app.add_option("--sbatch", sbatch, "additional option for sbatch, as in --sbatch=--partition=short (repeatable)")
        ->type_name("OPTION")
        ->allow_extra_args(false);
}

void add_sweep_options(CLI::App& app, SweepOptions& o) {
    app.add_option("study", o.study, "study file, or the name of a shipped study")->required()->type_name("STUDY");
    app.add_option("--out", o.out, "folder of the results (default: out/<study name>)")->type_name("DIR")->check(not_empty);
    add_slurm_options(app, o.on, o.sbatch);
    app.add_option("--threads", o.threads, "threads of each run (default: local: cores divided by --jobs, slurm: 1)")
        ->type_name("N")
        ->check(whole_number(0, 1024));
    app.add_option("--jobs", o.jobs,
                   "runs at the same time (default: local: 1 if time is measured, otherwise as many as the cores allow; slurm: 8)")
        ->type_name("N")
        ->check(whole_number(0, 1024));
    app.add_option("--budget", o.budget, "start no run after this wall time, as in 90s, 10min, 1h")->type_name("TIME");
    app.add_flag("--json", o.json, "print the result as JSON");
}

void Sweep::say(const std::string& text) const {
    if (!options.json) fmt::print("{}\n", text), std::fflush(stdout);
}

PointResult Sweep::point(const std::vector<std::string>& settings, int repeat, bool pictures) const try {
    return runner.run(scene, settings, repeat, pictures);
} catch (const InputError& error) {
    PointResult refused;
    refused.status = "refused", refused.message = error.what();
    return refused;
}

void Sweep::run(const std::function<Task(double)>& next) const {
    const double began = wall_seconds(), budget = seconds_of(options.budget);
    const auto left = [&] { return budget > 0 ? budget - (wall_seconds() - began) : std::numeric_limits<double>::infinity(); };
    std::vector<std::future<std::function<void()>>> running;
    for (;;) {
        const bool room = running.size() < static_cast<std::size_t>(options.jobs) && left() > 0;
        if (const Task task = room ? next(left()) : nullptr) {
            running.push_back(std::async(std::launch::async, task));
            continue;
        }
        if (running.empty()) return;
        const auto ended = std::find_if(running.begin(), running.end(),
                                        [](const auto& job) { return job.wait_for(std::chrono::seconds(0)) == std::future_status::ready; });
        if (ended == running.end()) {
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
            continue;
        }
        const auto done = ended->get();
        running.erase(ended);
        done();
    }
}

namespace {

/// Text of a CSV cell: numbers with six digits, unknown values empty, objects as "name value; name value".
std::string cell_of(const nlohmann::ordered_json& value) {
    if (value.is_string()) return csv_cell(value.get<std::string>());
    if (value.is_boolean()) return value.get<bool>() ? "1" : "0";
    if (value.is_number_float()) return std::isfinite(value.get<double>()) ? fmt::format("{:.6g}", value.get<double>()) : "";
    if (!value.is_object()) return value.is_null() ? "" : value.dump();
    std::string text;
    for (const auto& [name, number] : value.items())
        text += fmt::format("{}{} {:.3g}", text.empty() ? "" : "; ", name, number.get<double>());
    return csv_cell(text);
}

}  // namespace

void Sweep::write(const std::string& name, const Canvas& canvas, const std::vector<std::string>& columns, const char* rows_name,
                  const nlohmann::ordered_json& rows) const {
    std::string csv = "scene,";
    for (const Knob& knob : study.knobs) csv += csv_cell(knob.key) + ",";
    csv += csv_header(columns) + "\n";
    for (const auto& row : rows) {
        csv += csv_cell(fs::path(scene).stem().string()) + ",";
        for (const std::string setting : row.at("settings")) csv += csv_cell(setting.substr(setting.find('=') + 1)) + ",";
        for (std::size_t k = 0; k < columns.size(); ++k) csv += (k ? "," : "") + cell_of(row.at(columns[k]));
        csv += "\n";
    }
    write_text(folder / (name + ".csv"), csv);
    write_png(folder / (name + ".png"), canvas.image());
    write_text(folder / (name + ".svg"), canvas.svg());
    if (options.json)
        fmt::print("{}\n", json_text({{"study", study.name}, {"scene", scene}, {"folder", folder.string()}, {rows_name, rows}}, 2));
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
    try {
        for (const std::string& scene : study.scenes) {
            const fs::path own = study.scenes.size() == 1 ? folder : folder / fs::path(scene).stem();
            fs::create_directories(own);
            if (o.on == "slurm") prepare_jobs(own);
            sweep(Sweep{study, o, scene, own, {study, own, o.threads, o.on == "slurm", o.sbatch}});
        }
    } catch (const StudyInterrupted&) {
        fmt::print(stderr, "whorl: interrupted; finished points are kept, repeat the command to continue\n");
        return exit_interrupted;
    }
    return exit_done;
}

}  // namespace whorl
