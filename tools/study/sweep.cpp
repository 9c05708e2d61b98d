#include "tools/study/sweep.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <thread>

#include "tools/scene_file/options.h"

namespace whorl {

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

void share_cores(SweepOptions& o, bool timed) {
    if (o.on == "slurm") {
        constexpr int usual_jobs = 8;
        o.jobs = o.jobs > 0 ? o.jobs : usual_jobs, o.threads = std::max(1, o.threads);
        return;
    }
    const int cores = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
    if (o.jobs == 0) o.jobs = timed ? 1 : o.threads > 0 ? std::max(1, cores / o.threads) : cores;
    if (o.threads == 0) o.threads = std::max(1, cores / o.jobs);
}

PointPlace point_place(const SweepOptions& options) { return {options.on == "slurm", options.sbatch}; }

std::filesystem::path folder_of(const Study& study, const SweepOptions& options) {
    return options.out.empty() ? std::filesystem::path("out") / study.name : options.out;
}

std::vector<std::string> settings_at(const Study& study, const GridPoint& p) {
    std::vector<std::string> settings;
    for (std::size_t k = 0; k < study.knobs.size(); ++k) settings.push_back(study.knobs[k].key + "=" + study.knobs[k].values[p[k]]);
    return settings;
}

std::string label_at(const Study& study, const GridPoint& p) {
    std::string label;
    for (std::size_t k = 0; k < study.knobs.size(); ++k) {
        const std::string& value = study.knobs[k].values[p[k]];
        char* end = nullptr;
        const double number = std::strtod(value.c_str(), &end);
        label += (k ? ", " : "") + (*end == 0 && value.size() > 7 ? fmt::format("{:.3g}", number) : value);
    }
    return label;
}

double seconds_of(const std::string& budget) {
    if (budget.empty()) return 0;
    char* end = nullptr;
    const double number = std::strtod(budget.c_str(), &end);
    const std::string unit = end;
    const double scale = unit.empty() || unit == "s" ? 1 : unit == "min" || unit == "m" ? 60 : unit == "h" ? 3600 : 0;
    if (end == budget.c_str() || scale == 0 || !(number > 0))
        throw InputError({"--budget " + budget, 0, 0}, "is no time", "", "allowed: as in 90s, 10min, 1h");
    return number * scale;
}

}  // namespace whorl
