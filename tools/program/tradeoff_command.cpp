#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <deque>
#include <optional>

#include "engine/core/atomic_file.h"
#include "tools/film/progress.h"
#include "tools/program/command.h"
#include "tools/program/sweep.h"
#include "tools/scene_file/scene_changes.h"
#include "tools/study/pareto_search.h"
#include "tools/study/plot.h"

namespace whorl {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

/// The trade-off of one scene of a study.
class Tradeoff {
public:
    explicit Tradeoff(const Sweep& sweep) : sweep_(sweep), study_(sweep.study), options_(sweep.options), search_(levels_of(sweep.study)) {}

    void run() {
        find_reference();
        sweep_.run([&](double left) -> Sweep::Task {
            GridPoint p;
            if (!options_.all) p = search_.next(measured(true), left / wall_over_cost());
            else if (rows_.size() < search_.size()) p = search_.point(rows_.size());
            if (p.empty()) return nullptr;
            rows_.push_back({{p}, settings_at(study_, p), {}, {}});
            return [this, k = rows_.size() - 1, settings = rows_.back().settings] {
                return [this, k, result = sweep_.point(settings, study_.cost.repeat, draws())] { measure(rows_[k], result); };
            };
        });
        if (!options_.budget.empty() && rows_.size() < search_.size() && !search_.next(measured(false)).empty())
            sweep_.say(
                fmt::format("the budget of {} is used up, or too small for the next point of the front; repeat the command "
                            "with a larger budget to continue",
                            options_.budget));
        front_ = pareto_front(measured(false));
        write();
        print_front();
        if (!options_.recommend.empty()) recommend();
    }

private:
    struct Row {
        Measured measured;
        std::vector<std::string> settings;
        std::optional<PointResult> result;  ///< empty while it runs
        std::vector<double> costs;          ///< cost of each timing, sorted
    };

    static std::vector<int> levels_of(const Study& study) {
        std::vector<int> levels;
        for (const Knob& knob : study.knobs) levels.push_back(static_cast<int>(knob.values.size()));
        return levels;
    }

    /// Measured points. @param expected whether to add the running points with their expected values, so that the search does not choose
    /// two points for the same purpose
    std::vector<Measured> measured(bool expected) const {
        std::vector<Measured> done;
        for (const Row& row : rows_)
            if (row.result) done.push_back(row.measured);
        std::vector<Measured> all = done;
        for (const Row& row : rows_)
            if (expected && !row.result) all.push_back(search_.expected(row.measured.at, done));
        return all;
    }

    /// Mean ratio of a point's wall seconds (of all its timings) to its cost, over the finished points; 0 before the first.
    double wall_over_cost() const {
        double wall = 0, cost = 0;
        for (const Row& row : rows_) {
            if (row.costs.empty()) continue;
            for (const double w : row.result->wall) wall += w;
            cost += row.measured.cost;
        }
        return cost > 0 ? wall / cost : 0;
    }

    /// Upper bound of the remaining wall seconds: that all other points are run. The search usually ends earlier.
    double most_left() const {
        const std::vector<Measured> done = measured(false);
        double cost = 0;
        for (std::size_t k = 0; k < search_.size(); ++k)
            if (const GridPoint p = search_.point(k); std::none_of(done.begin(), done.end(), [&](const Measured& m) { return m.at == p; }))
                cost += search_.expected(p, done).cost;
        return cost * wall_over_cost() / options_.jobs;
    }

    void find_reference() {
        const AccuracyKeys& accuracy = study_.accuracy;
        if (accuracy.of != AccuracyKind::reference && accuracy.of != AccuracyKind::picture) return;
        sweep_.say(fmt::format("the reference run: {}", joined_settings(accuracy.reference)));
        const PointResult truth = sweep_.runner.run(sweep_.scene, accuracy.reference, 1, draws());
        if (!truth.done()) throw EnvironmentError(fmt::format("the reference run ended as {}: {}", truth.status, truth.message));
        reference_ = truth.folder;
    }

    bool draws() const { return study_.pictures || study_.accuracy.of == AccuracyKind::picture; }

    void measure(Row& row, const PointResult& result) {
        const bool first = measured(false).empty();
        if (first && result.status == "refused") throw InputError({study_.name, 0, 0}, result.message);
        row.result = result;
        if (result.status != "refused") row.costs = study_.cost.of == CostKind::cpu ? result.cpu : result.wall;
        if (study_.cost.of == CostKind::memory) row.costs.assign(row.costs.empty() ? 0 : 1, result.memory);
        std::sort(row.costs.begin(), row.costs.end());
        Measured& m = row.measured;
        m.cost = row.costs.empty() ? unknown : row.costs[row.costs.size() / 2];
        m.error = result.done() ? error_of(study_.accuracy, result.folder, reference_) : unknown;
        sweep_.say(fmt::format("point {} of {} {}: {}: {}, {}{} ({} {} left)", measured(false).size(), options_.all ? "the" : "at most",
                               search_.size(), joined_settings(row.settings), cost_text(m.cost),
                               result.done() ? "error " + error_text(m.error) : result.status + " (" + result.message + ")",
                               result.kept ? ", kept from an earlier sweep" : "", options_.all ? "about" : "at most",
                               duration(most_left())));
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

    /// Writes table and plot. The plot contains the points of the front, then the other finished ones.
    void write() const {
        Json rows = Json::array();
        std::vector<PlotPoint> points, others;
        for (std::size_t i = 0; i < rows_.size(); ++i) {
            const Row& r = rows_[i];
            const double low = r.costs.empty() ? 0 : r.costs.front(), high = r.costs.empty() ? 0 : r.costs.back();
            const bool on_front = std::find(front_.begin(), front_.end(), i) != front_.end();
            rows.push_back({{"settings", r.settings},
                            {"cost", r.measured.cost},
                            {"cost_low", low},
                            {"cost_high", high},
                            {"error", r.measured.error},
                            {"wall_seconds", r.result->wall.empty() ? 0 : r.result->wall.front()},
                            {"memory_bytes", r.result->memory},
                            {"fps", r.result->fps()},
                            {"on_front", on_front},
                            {"status", r.result->status},
                            {"message", r.result->message},
                            {"kept", r.result->kept}});
            if (std::isfinite(r.measured.error) && !on_front) others.push_back({r.measured.cost, r.measured.error, low, high, "", false});
        }
        for (const std::size_t i : front_) {
            const Row& r = rows_[i];
            points.push_back({r.measured.cost, r.measured.error, r.costs.front(), r.costs.back(), label_at(study_, r.measured.at), true});
        }
        points.insert(points.end(), others.begin(), others.end());
        std::vector<std::string> titles;
        for (const Knob& knob : study_.knobs) titles.push_back(knob.title());
        const Canvas plot = draw_front(points, fmt::format("{}: {}", study_.name, fmt::join(titles, ", ")), cost_name(),
                                       study_.accuracy.of == AccuracyKind::picture ? "difference [dE]" : "relative error");
        sweep_.write("tradeoff", plot,
                     {"cost", "cost_low", "cost_high", "error", "wall_seconds", "memory_bytes", "fps", "on_front", "status", "message"},
                     "points", rows);
    }

    /// Prints change, cost and benefit of each step along the front.
    void print_front() const {
        sweep_.say(fmt::format("\n{:>14}  {:>10}  settings on the front, cheapest first", cost_name(), "error"));
        for (const std::size_t i : front_)
            sweep_.say(fmt::format("{:>14}  {:>10}  {}", cost_text(rows_[i].measured.cost), error_text(rows_[i].measured.error),
                                   joined_settings(rows_[i].settings)));
        for (std::size_t k = 1; k < front_.size(); ++k) {
            const Measured &a = rows_[front_[k - 1]].measured, &b = rows_[front_[k]].measured;
            std::vector<std::string> changes;
            for (std::size_t j = 0; const Knob& knob : study_.knobs)
                if (const auto from = a.at[j], to = b.at[j++]; from != to)
                    changes.push_back(fmt::format("{} {} -> {}", knob.key, knob.values[from], knob.values[to]));
            sweep_.say(fmt::format("  {}: {:.2g} times the {}, error {} -> {}", fmt::join(changes, ", "), b.cost / a.cost,
                                   study_.cost.of == CostKind::memory ? "memory" : "time", error_text(a.error), error_text(b.error)));
        }
        const auto failed = std::count_if(rows_.begin(), rows_.end(), [](const Row& r) { return !r.result->done(); });
        if (failed > 0) sweep_.say(fmt::format("{} of {} points failed; see the column message of tradeoff.csv", failed, rows_.size()));
        sweep_.say(fmt::format("{0}/tradeoff.csv, {0}/tradeoff.png, {0}/tradeoff.svg", sweep_.folder.string()));
    }

    void recommend() const {
        const Goal goal = parse_goal(options_.recommend);
        const Row* best = nullptr;
        for (const Row& row : rows_) {
            const Measured& m = row.measured;
            if (!std::isfinite(m.error) || !goal.holds(m.cost, m.error, row.result->fps())) continue;
            // For a goal of accuracy take the cheapest point that reaches it, otherwise the most accurate.
            if (!best || (goal.of == Goal::Of::error ? m.cost < best->measured.cost : m.error < best->measured.error)) best = &row;
        }
        if (!best)
            throw EnvironmentError(fmt::format("no point of the study reaches the goal {}", goal.text), "", "add values to the knobs");
        const PointCall call = point_call(study_, sweep_.scene, best->settings);
        std::string options = call.options.quality == Options().quality ? "" : " --quality " + call.options.quality;
        const std::string found = fmt::format("{}, error {}", cost_text(best->measured.cost), error_text(best->measured.error));
        std::string overlay =
            fmt::format("# {} of the study {}: {}{}\n", goal.text, study_.name, found, options.empty() ? "" : ", with" + options);
        if (!call.program.empty()) overlay += "# with the program " + call.program + "\n";
        if (!call.threads.empty()) options += " --threads " + call.threads;
        for (const std::string& setting : call.options.set) {
            if (std::find(study_.set.begin(), study_.set.end(), setting) != study_.set.end()) continue;  // the study sets it at every point
            const std::string key = setting.substr(0, setting.find('='));
            const std::string quote = key.find('[') == std::string::npos ? "" : "\"";  // quotes for a key with an index
            overlay += quote + key + quote + " = " + parse_change(setting).value.toml() + "\n";
        }
        const fs::path file = sweep_.folder / "recommended.toml";
        write_text(file, overlay);
        sweep_.say(fmt::format("\nfor {}: {} ({}). To render with these settings, from {}:\n  whorl render {} --with {}{}", goal.text,
                               joined_settings(best->settings), found, file.string(), call.options.scene, file.string(), options));
    }

    const Sweep& sweep_;
    const Study& study_;
    const SweepOptions& options_;
    const ParetoSearch search_;
    fs::path reference_;
    std::deque<Row> rows_;            ///< in the order in which they were started
    std::vector<std::size_t> front_;  ///< indices of rows, cheapest first
};

int run_tradeoff(const SweepOptions& options) {
    const Study study = read_study(options.study);
    if (study.knobs.empty()) throw InputError({options.study, 0, 0}, "the study has no knob", "add a [[knob]] with key and values");
    if (study.accuracy.column.empty() && study.accuracy.of != AccuracyKind::picture)
        throw InputError({options.study, 0, 0}, "accuracy.column is missing", "set it to a column of accuracy.table");
    if (!options.recommend.empty()) parse_goal(options.recommend);
    return run_sweeps(study, options, study.cost.of != CostKind::memory, [](const Sweep& sweep) { Tradeoff(sweep).run(); });
}

}  // namespace

void add_tradeoff(CLI::App& program, Job& chosen) {
    const auto [app, o] =
        add_command(program, chosen, "tradeoff", "sweep settings, measure cost and error of each, draw the Pareto front", run_tradeoff,
                    "Each point is a run in a separate process. Finished points are kept: repeat the command to continue a stopped study.\n"
                    "Points that failed, or whose scene was edited since, are run again.\n"
                    "Examples:\n"
                    "  whorl tradeoff coil_frequency --budget 10min\n"
                    "  whorl tradeoff coil_frequency --recommend \"error<5%\"\n"
                    "  whorl tradeoff coil_frequency --on slurm --jobs 20 --sbatch=--partition=short\n"
                    "  whorl render honey_coil --with out/coil_frequency/recommended.toml");
    add_sweep_options(app, o);
    app.add_flag("--all", o.all, "run the whole grid, not only the points that may lie on the front");
    app.add_option("--recommend", o.recommend,
                   "print the best settings that reach this goal and write them to recommended.toml: \"error<2%\", \"fps>24\"")
        ->type_name("GOAL");
}

}  // namespace whorl
