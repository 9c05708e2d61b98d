#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <memory>

#include "engine/core/whole_file.h"
#include "engine/io/csv.h"
#include "tools/film/progress.h"
#include "tools/program/command.h"
#include "tools/program/sweep.h"
#include "tools/scene_file/scene_changes.h"
#include "tools/study/plot.h"
#include "tools/study/point.h"

namespace whorl {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct Row {
    PointResult result;
    double cost_low = 0, cost_high = 0;
};

/// The trade-off of one scene of a study.
class Tradeoff {
public:
    explicit Tradeoff(const Sweep& sweep) : sweep_(sweep), study_(sweep.study), options_(sweep.options) {}

    void run() {
        find_reference();
        std::vector<int> levels;
        for (const Knob& knob : study_.knobs) levels.push_back(static_cast<int>(knob.values.size()));
        const FrontSearch search(levels);
        std::vector<GridPoint> started;
        /// The points that were measured, and those that run as they are expected, so that no two ask the same question.
        const auto known = [&] {
            std::vector<Measured> all = measured_;
            for (const GridPoint& p : started)
                if (!was_measured(p)) all.push_back(search.expected(p, measured_));
            return all;
        };
        const auto next = [&](double left) -> std::function<PointResult()> {
            GridPoint p;
            if (!options_.all) p = search.next(known(), left / wall_over_cost());
            else if (started.size() < search.size()) p = search.point(started.size());
            if (p.empty()) return nullptr;
            started.push_back(p);
            return [this, settings = settings_at(study_, p)] { return run_point(settings); };
        };
        sweep_.run<PointResult>(next, [&](std::size_t k, PointResult result) { measure(started[k], std::move(result), search); });
        if (!options_.budget.empty() && started.size() < search.size() && !search.next(known()).empty())
            sweep_.say(
                fmt::format("the budget of {} is spent, or what is left does not suffice for the rest of the front; the same command "
                            "with a larger budget continues from here",
                            options_.budget));
        write();
    }

private:
    bool was_measured(const GridPoint& p) const {
        return std::any_of(measured_.begin(), measured_.end(), [&](const Measured& m) { return m.at == p; });
    }

    /// A point that the plan refuses is a result, too.
    PointResult run_point(const std::vector<std::string>& settings) const try {
        return sweep_.runner.run(sweep_.scene, settings, study_.cost.repeat, draws());
    } catch (const InputError& error) {
        PointResult refused;
        refused.status = "refused", refused.message = error.what();
        return refused;
    }

    /// Wall seconds of a point (all its timings) over its cost, from those that were run; before the first, unknown: 0.
    double wall_over_cost() const {
        double wall = 0, cost = 0;
        for (std::size_t i = 0; i < rows_.size(); ++i) {
            for (const double w : rows_[i].result.wall) wall += w;
            if (std::isfinite(measured_[i].cost)) cost += measured_[i].cost;
        }
        return cost > 0 ? wall / cost : 0;
    }

    /// Wall seconds that all points not yet run would take: the search stops earlier.
    double most_left(const FrontSearch& search) const {
        double cost = 0;
        for (std::size_t k = 0; k < search.size(); ++k)
            if (const GridPoint p = search.point(k); !was_measured(p)) cost += search.expected(p, measured_).cost;
        return cost * wall_over_cost() / options_.jobs;
    }

    void find_reference() {
        const AccuracyKind of = study_.accuracy.of;
        if (of != AccuracyKind::reference && of != AccuracyKind::picture) return;
        sweep_.say(fmt::format("the run that counts as true: {}", joined_settings(study_.accuracy.reference)));
        const PointResult truth = sweep_.runner.run(sweep_.scene, study_.accuracy.reference, on_grid() ? study_.cost.repeat : 1, draws());
        if (!truth.done()) throw EnvironmentError(fmt::format("the run that counts as true ended as {}: {}", truth.status, truth.message));
        reference_ = truth.folder;
    }

    /// Whether the run that counts as true is also a point of the grid: then it is timed like one, and not run again.
    bool on_grid() const {
        const std::vector<std::string>& truth = study_.accuracy.reference;
        std::size_t on = 0;
        for (std::size_t k = 0; k < std::min(truth.size(), study_.knobs.size()); ++k)
            for (const std::string& value : study_.knobs[k].values) on += truth[k] == study_.knobs[k].key + "=" + value ? 1 : 0;
        return truth.size() == study_.knobs.size() && on >= truth.size();
    }

    bool draws() const { return study_.pictures || study_.accuracy.of == AccuracyKind::picture; }

    void measure(const GridPoint& p, PointResult result, const FrontSearch& search) {
        const std::vector<std::string> settings = settings_at(study_, p);
        Row row{std::move(result)};
        if (measured_.empty() && row.result.status == "refused") throw InputError({study_.name, 0, 0}, row.result.message);
        Measured m{p, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::quiet_NaN()};
        std::vector<double> costs = study_.cost.of == CostKind::cpu ? row.result.cpu : row.result.wall;
        if (study_.cost.of == CostKind::memory) costs = {row.result.memory};
        std::sort(costs.begin(), costs.end());
        if (!costs.empty() && row.result.status != "refused") {
            row.cost_low = costs.front(), row.cost_high = costs.back();
            m.cost = costs[costs.size() / 2];
        }
        if (row.result.done()) m.error = error_of(study_.accuracy, row.result.folder, reference_);
        measured_.push_back(m), rows_.push_back(row);
        sweep_.say(fmt::format("point {} of {} {}: {}: {}, {}{} ({} {} left)", measured_.size(), options_.all ? "the" : "at most",
                               search.size(), joined_settings(settings), cost_text(m.cost),
                               row.result.done() ? "error " + error_text(m.error) : row.result.status + " (" + row.result.message + ")",
                               row.result.kept ? ", kept from before" : "", options_.all ? "about" : "at most",
                               duration(most_left(search))));
    }

    std::string cost_text(double cost) const {
        if (!std::isfinite(cost)) return "no cost";
        if (study_.cost.of == CostKind::memory) return fmt::format("{:.0f} MB", 1e-6 * cost);
        return fmt::format("{:.3g} s{}", cost, study_.cost.of == CostKind::cpu ? " CPU" : "");
    }
    const char* cost_name() const {
        return study_.cost.of == CostKind::cpu ? "CPU seconds" : study_.cost.of == CostKind::wall ? "wall seconds" : "peak memory [bytes]";
    }
    std::string error_text(double error) const {
        return study_.accuracy.of == AccuracyKind::picture ? fmt::format("{:.3g} dE", error) : fmt::format("{:.3g} %", 100 * error);
    }

    void write() {
        const std::vector<std::size_t> front = pareto_front(measured_);
        sweep_.write("tradeoff", table(front), plot(front));
        print_front(front);
        if (!options_.recommend.empty()) recommend();
        Json points = Json::array();
        for (std::size_t i = 0; i < rows_.size(); ++i)
            points.push_back({{"settings", settings_at(study_, measured_[i].at)},
                              {"cost", measured_[i].cost},
                              {"error", measured_[i].error},
                              {"status", rows_[i].result.status},
                              {"on_front", has(front, i)},
                              {"kept", rows_[i].result.kept}});
        sweep_.print_json("points", points);
    }

    static bool has(const std::vector<std::size_t>& front, std::size_t i) {
        return std::find(front.begin(), front.end(), i) != front.end();
    }

    std::string table(const std::vector<std::size_t>& front) const {
        std::string csv = "scene";
        for (const Knob& knob : study_.knobs) csv += "," + csv_cell(knob.key);
        csv += ",cost,cost_low,cost_high,error,wall_seconds,memory_bytes,fps,on_front,status,message\n";
        for (std::size_t i = 0; i < rows_.size(); ++i) {
            const Row& r = rows_[i];
            csv += csv_cell(fs::path(sweep_.scene).stem().string());
            for (std::size_t k = 0; k < study_.knobs.size(); ++k) csv += "," + csv_cell(study_.knobs[k].values[measured_[i].at[k]]);
            csv +=
                fmt::format(",{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.0f},{:.4g},{},{},{}\n", measured_[i].cost, r.cost_low, r.cost_high,
                            measured_[i].error, r.result.wall.empty() ? 0 : r.result.wall.front(), r.result.memory,
                            r.result.wall.empty() ? 0 : r.result.fps(), has(front, i) ? 1 : 0, r.result.status, csv_cell(r.result.message));
        }
        return csv;
    }

    Canvas plot(const std::vector<std::size_t>& front) const {
        std::vector<PlotPoint> points;
        const auto point = [&](std::size_t i) {
            return PlotPoint{
                measured_[i].cost, measured_[i].error, rows_[i].cost_low, rows_[i].cost_high, label_at(study_, measured_[i].at),
                has(front, i)};
        };
        for (const std::size_t i : front) points.push_back(point(i));
        for (std::size_t i = 0; i < measured_.size(); ++i)
            if (!has(front, i) && std::isfinite(measured_[i].error)) points.push_back(point(i));
        std::vector<std::string> titles;
        for (const Knob& knob : study_.knobs) titles.push_back(knob.title());
        return draw_front(points, fmt::format("{}: {}", study_.name, fmt::join(titles, ", ")), cost_name(),
                          study_.accuracy.of == AccuracyKind::picture ? "difference [dE]" : "relative error");
    }

    /// Prints change, cost and benefit of each step along the front.
    void print_front(const std::vector<std::size_t>& front) const {
        sweep_.say(fmt::format("\n{:>14}  {:>10}  settings on the front, from cheap to dear", cost_name(), "error"));
        for (const std::size_t i : front)
            sweep_.say(fmt::format("{:>14}  {:>10}  {}", cost_text(measured_[i].cost), error_text(measured_[i].error),
                                   joined_settings(settings_at(study_, measured_[i].at))));
        for (std::size_t k = 1; k < front.size(); ++k) {
            const Measured &a = measured_[front[k - 1]], &b = measured_[front[k]];
            std::vector<std::string> changes;
            for (std::size_t j = 0; const Knob& knob : study_.knobs)
                if (const auto from = a.at[j], to = b.at[j++]; from != to)
                    changes.push_back(fmt::format("{} {} -> {}", knob.key, knob.values[from], knob.values[to]));
            sweep_.say(fmt::format("  {}: {:.2g} times the {}, error {} -> {}", fmt::join(changes, ", "), b.cost / a.cost,
                                   study_.cost.of == CostKind::memory ? "memory" : "time", error_text(a.error), error_text(b.error)));
        }
        const auto failed = std::count_if(rows_.begin(), rows_.end(), [](const Row& r) { return !r.result.done(); });
        if (failed > 0) sweep_.say(fmt::format("{} of {} points did not end well; tradeoff.csv says how", failed, rows_.size()));
        sweep_.say(fmt::format("{0}/tradeoff.csv, {0}/tradeoff.png, {0}/tradeoff.svg", sweep_.folder.string()));
    }

    void recommend() const {
        const Goal goal = parse_goal(options_.recommend);
        const Measured* best = nullptr;
        for (std::size_t i = 0; i < rows_.size(); ++i) {
            const Measured& m = measured_[i];
            if (!std::isfinite(m.error) || !goal.holds(m.cost, m.error, rows_[i].result.fps())) continue;
            // The cheapest that is accurate enough, or the most accurate that is cheap enough.
            if (!best || (goal.of == Goal::Of::error ? m.cost < best->cost : m.error < best->error)) best = &m;
        }
        if (!best) throw EnvironmentError(fmt::format("no point of the study reaches {}", goal.text), "", "widen the knobs' values");
        const Options point = point_options(study_, sweep_.scene, run_settings(study_, settings_at(study_, best->at)));
        const std::string quality = point.quality == Options().quality ? "" : " --quality " + point.quality;
        std::string overlay = fmt::format("# {} of the study {}: {}, error {}{}\n", goal.text, study_.name, cost_text(best->cost),
                                          error_text(best->error), quality.empty() ? "" : ", with" + quality);
        // Settings of all points belong to the study, settings that follow from a knob to the knob.
        std::string options = quality;
        std::vector<std::string> chosen;
        for (const std::string& setting : study_.set)
            if (setting.find('{') != std::string::npos) chosen.push_back(with_values(setting, settings_at(study_, best->at)));
        for (const std::string& setting : settings_at(study_, best->at))
            if (!is_name(setting.substr(0, setting.find('=')))) chosen.push_back(setting);
        for (const std::string& setting : chosen) {
            const std::size_t equals = setting.find('=');
            const std::string key = setting.substr(0, equals), value = setting.substr(equals + 1);
            if (key == "scene" || key == "quality") continue;  // in the command
            if (key == "program") overlay += "# with the program " + value + "\n";
            else if (key == "threads") options += " --threads " + value;
            else overlay += fmt::format("{} = {}\n", quoted(key), parse_change(setting).value.toml());
        }
        const fs::path file = sweep_.folder / "recommended.toml";
        write_text(file, overlay);
        sweep_.say(fmt::format("\nfor {}: {} ({}, error {}); {} holds them:\n  whorl render {} --with {}{}", goal.text,
                               joined_settings(settings_at(study_, best->at)), cost_text(best->cost), error_text(best->error),
                               file.string(), point.scene, file.string(), options));
    }

    /// A key of an overlay: with quotes if it names a list entry.
    static std::string quoted(const std::string& key) { return key.find('[') == std::string::npos ? key : "\"" + key + "\""; }

    const Sweep& sweep_;
    const Study& study_;
    const SweepOptions& options_;
    fs::path reference_;
    std::vector<Measured> measured_;
    std::vector<Row> rows_;
};

}  // namespace

int run_tradeoff(const SweepOptions& options) {
    const Study study = read_study(options.study);
    if (study.knobs.empty()) throw InputError({options.study, 0, 0}, "the study has no knob", "add a [[knob]] with key and values");
    if (study.accuracy.column.empty() && study.accuracy.of != AccuracyKind::picture)
        throw InputError({options.study, 0, 0}, "accuracy.column is missing", "it names a column of accuracy.table");
    if (!options.recommend.empty()) parse_goal(options.recommend);
    return run_sweeps(study, options, study.cost.of != CostKind::memory, [](const Sweep& sweep) { Tradeoff(sweep).run(); });
}

void add_tradeoff(CLI::App& program, Job& chosen) {
    const auto options = std::make_shared<SweepOptions>();
    CLI::App* app =
        program.add_subcommand("tradeoff", "sweep settings, measure what accuracy they buy and what they cost, draw the Pareto front");
    add_sweep_options(*app, *options);
    app->add_flag("--all", options->all, "run the whole grid, not only what the front may need");
    app->add_option("--recommend", options->recommend,
                    "print the cheapest settings that reach it and write them as an overlay: \"error<2%\", \"fps>24\"")
        ->type_name("GOAL");
    app->footer(
        "Each point is a run in its own process and is kept: calling a stopped study again continues it.\n"
        "Points that failed, or whose scene was edited since, are run again.\n"
        "Examples:\n"
        "  whorl tradeoff coil_frequency --budget 10min\n"
        "  whorl tradeoff coil_frequency --recommend \"error<5%\"\n"
        "  whorl tradeoff coil_frequency --on slurm --jobs 20 --sbatch=--partition=short\n"
        "  whorl render honey_coil --with out/coil_frequency/recommended.toml");
    app->callback([options, &chosen] { chosen = [options] { return run_tradeoff(*options); }; });
}

}  // namespace whorl
