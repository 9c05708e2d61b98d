#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "engine/core/clock.h"
#include "engine/core/whole_file.h"
#include "tools/command.h"
#include "tools/run/progress.h"
#include "tools/study/accuracy.h"
#include "tools/study/plot.h"
#include "tools/study/recommend.h"
#include "tools/study/sweep.h"

namespace whorl {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct Row {
    std::string scene;
    PointResult result;
    double cost_low = 0, cost_high = 0;
};

/// One scene of a study, swept.
class Tradeoff {
public:
    Tradeoff(const Study& study, const SweepOptions& options, std::string scene, fs::path folder)
        : study_(study), options_(options), scene_(std::move(scene)), folder_(std::move(folder)), runner_(study, folder_, options.threads) {}

    void run() {
        const double began = wall_seconds(), budget = seconds_of(options_.budget);
        find_reference();
        std::vector<int> levels;
        for (const Knob& knob : study_.knobs) levels.push_back(static_cast<int>(knob.values.size()));
        const FrontSearch search(levels);
        for (std::size_t k = 0; options_.all ? k < search.size() : true; ++k) {
            const GridPoint next = options_.all ? grid_point(levels, k) : search.next(measured_);
            if (next.empty()) break;
            if (budget > 0 && wall_seconds() - began > budget) {
                say(fmt::format("the budget of {} is spent; the same command with a larger one goes on from here", options_.budget));
                break;
            }
            measure(next, search.size());
        }
        write();
    }

private:
    static GridPoint grid_point(const std::vector<int>& levels, std::size_t k) {
        GridPoint p;
        for (const int l : levels) p.push_back(static_cast<int>(k % static_cast<std::size_t>(l))), k /= static_cast<std::size_t>(l);
        return p;
    }

    void say(const std::string& text) const {
        if (!options_.json) fmt::print("{}\n", text), std::fflush(stdout);
    }

    void find_reference() {
        const AccuracyKind of = study_.accuracy.of;
        if (of != AccuracyKind::reference && of != AccuracyKind::picture) return;
        say(fmt::format("the run that counts as true: {}", joined_settings(study_.accuracy.reference)));
        const PointResult truth = runner_.run(scene_, study_.accuracy.reference, 1, draws());
        if (!truth.done()) throw EnvironmentError(fmt::format("the run that counts as true ended as {}: {}", truth.status, truth.message));
        reference_ = truth.folder;
    }

    bool draws() const { return study_.pictures || study_.accuracy.of == AccuracyKind::picture; }

    void measure(const GridPoint& p, std::size_t most) {
        const std::vector<std::string> settings = settings_at(study_, p);
        Row row{scene_, runner_.run(scene_, settings, study_.cost.repeat, draws())};
        Measured m{p, NAN, NAN};
        std::vector<double> costs = study_.cost.of == CostKind::cpu ? row.result.cpu : row.result.wall;
        if (study_.cost.of == CostKind::memory) costs = {row.result.memory};
        std::sort(costs.begin(), costs.end());
        row.cost_low = costs.front(), row.cost_high = costs.back();
        m.cost = costs[costs.size() / 2];
        if (row.result.done()) m.error = error_of(study_.accuracy, row.result.folder, reference_);
        measured_.push_back(m), rows_.push_back(row);
        say(fmt::format("point {} of at most {}: {}: {}, {}{}", measured_.size(), most, joined_settings(settings), cost_text(m.cost),
                        row.result.done() ? "error " + error_text(m.error) : row.result.status + " (" + row.result.message + ")",
                        row.result.kept ? " (kept from before)" : ""));
    }

    std::string cost_text(double cost) const {
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
        write_table(front);
        draw(front);
        print_front(front);
        if (!options_.recommend.empty()) recommend();
        if (options_.json) print_json(front);
    }

    static bool has(const std::vector<std::size_t>& front, std::size_t i) { return std::find(front.begin(), front.end(), i) != front.end(); }

    void write_table(const std::vector<std::size_t>& front) const {
        std::string csv = "scene";
        for (const Knob& knob : study_.knobs) csv += "," + csv_cell(knob.key);
        csv += ",cost,cost_low,cost_high,error,wall_seconds,memory_bytes,fps,on_front,status,message\n";
        for (std::size_t i = 0; i < rows_.size(); ++i) {
            const Row& r = rows_[i];
            csv += csv_cell(r.scene);
            for (std::size_t k = 0; k < study_.knobs.size(); ++k) csv += "," + csv_cell(study_.knobs[k].values[static_cast<std::size_t>(measured_[i].at[k])]);
            csv += fmt::format(",{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.0f},{:.4g},{},{},{}\n", measured_[i].cost, r.cost_low, r.cost_high, measured_[i].error,
                               r.result.wall.front(), r.result.memory, r.result.fps(), has(front, i) ? 1 : 0, r.result.status, csv_cell(r.result.message));
        }
        write_text(folder_ / "tradeoff.csv", csv);
    }

    void draw(const std::vector<std::size_t>& front) const {
        std::vector<PlotPoint> points;
        const auto point = [&](std::size_t i) {
            return PlotPoint{measured_[i].cost, measured_[i].error, rows_[i].cost_low, rows_[i].cost_high, label_at(study_, measured_[i].at), has(front, i)};
        };
        for (const std::size_t i : front) points.push_back(point(i));
        for (std::size_t i = 0; i < measured_.size(); ++i)
            if (!has(front, i) && std::isfinite(measured_[i].error)) points.push_back(point(i));
        std::string keys;
        for (const Knob& knob : study_.knobs) keys += (keys.empty() ? "" : ", ") + knob.key;
        const Canvas canvas = draw_front(points, fmt::format("{}: {}", study_.name, keys), cost_name(),
                                         study_.accuracy.of == AccuracyKind::picture ? "difference [dE]" : "relative error");
        write_png(folder_ / "tradeoff.png", canvas.image());
        write_text(folder_ / "tradeoff.svg", canvas.svg());
    }

    /// What each step along the front changes, costs and buys.
    void print_front(const std::vector<std::size_t>& front) const {
        say(fmt::format("\n{:>14}  {:>10}  settings on the front, from cheap to dear", cost_name(), "error"));
        for (const std::size_t i : front)
            say(fmt::format("{:>14}  {:>10}  {}", cost_text(measured_[i].cost), error_text(measured_[i].error), joined_settings(settings_at(study_, measured_[i].at))));
        for (std::size_t k = 1; k < front.size(); ++k) {
            const Measured &a = measured_[front[k - 1]], &b = measured_[front[k]];
            std::string changes;
            for (std::size_t j = 0; j < study_.knobs.size(); ++j)
                if (a.at[j] != b.at[j])
                    changes += fmt::format("{}{} {} -> {}", changes.empty() ? "" : ", ", study_.knobs[j].key, study_.knobs[j].values[static_cast<std::size_t>(a.at[j])],
                                           study_.knobs[j].values[static_cast<std::size_t>(b.at[j])]);
            say(fmt::format("  {}: {:.2g} times the {}, error {} -> {}", changes, b.cost / a.cost, study_.cost.of == CostKind::memory ? "memory" : "time",
                            error_text(a.error), error_text(b.error)));
        }
        const auto failed = std::count_if(rows_.begin(), rows_.end(), [](const Row& r) { return !r.result.done(); });
        if (failed > 0) say(fmt::format("{} of {} points did not end well; tradeoff.csv says how", failed, rows_.size()));
        say(fmt::format("{0}/tradeoff.csv, {0}/tradeoff.png, {0}/tradeoff.svg", folder_.string()));
    }

    void recommend() const {
        const Wish wish = parse_wish(options_.recommend);
        const Measured* best = nullptr;
        for (std::size_t i = 0; i < rows_.size(); ++i) {
            const Measured& m = measured_[i];
            if (!std::isfinite(m.error) || !wish.holds(m.cost, m.error, rows_[i].result.fps())) continue;
            // The cheapest that is accurate enough, or the most accurate that is cheap enough.
            if (!best || (wish.of == Wish::Of::error ? m.cost < best->cost : m.error < best->error)) best = &m;
        }
        if (!best) throw EnvironmentError(fmt::format("no point of the study reaches {}", wish.text), "", "widen the knobs' values");
        std::string overlay = fmt::format("# {} of the study {}: {}, error {}\n", wish.text, study_.name, cost_text(best->cost), error_text(best->error));
        std::vector<std::string> options;
        for (const std::string& setting : settings_at(study_, best->at)) {
            const std::size_t equals = setting.find('=');
            const std::string key = setting.substr(0, equals), value = setting.substr(equals + 1);
            if (key == "scene" || key == "quality" || key == "threads" || key == "program") options.push_back("--" + key + " " + value);
            else overlay += fmt::format("{} = {}\n", key, toml_value(value));
        }
        const fs::path file = folder_ / "recommended.toml";
        write_text(file, overlay);
        say(fmt::format("\nfor {}: {} ({}, error {}); {} holds them:\n  whorl render {} --with {}", wish.text, joined_settings(settings_at(study_, best->at)),
                        cost_text(best->cost), error_text(best->error), file.string(), scene_, file.string()));
    }

    /// A value as TOML writes it: bare words are texts.
    static std::string toml_value(const std::string& value) {
        char* end = nullptr;
        std::strtod(value.c_str(), &end);
        if ((*end == 0 && !value.empty()) || value == "true" || value == "false" || value.front() == '[' || value.front() == '"') return value;
        return "\"" + value + "\"";
    }

    void print_json(const std::vector<std::size_t>& front) const {
        Json points = Json::array();
        for (std::size_t i = 0; i < rows_.size(); ++i)
            points.push_back({{"settings", settings_at(study_, measured_[i].at)}, {"cost", measured_[i].cost}, {"error", measured_[i].error},
                              {"status", rows_[i].result.status}, {"on_front", has(front, i)}, {"kept", rows_[i].result.kept}});
        fmt::print("{}\n", Json{{"study", study_.name}, {"scene", scene_}, {"folder", folder_.string()}, {"points", points}}.dump(2));
    }

    const Study& study_;
    const SweepOptions& options_;
    std::string scene_;
    fs::path folder_;
    PointRunner runner_;
    fs::path reference_;
    std::vector<Measured> measured_;
    std::vector<Row> rows_;
};

int tradeoff(const SweepOptions& options) {
    const Study study = read_study(options.study);
    if (study.knobs.empty()) throw InputError({options.study, 0, 0}, "the study turns no knob", "add a [[knob]] with key and values");
    if (study.accuracy.column.empty() && study.accuracy.of != AccuracyKind::picture)
        throw InputError({options.study, 0, 0}, "accuracy.column is missing", "it names a column of accuracy.table");
    if (!options.recommend.empty()) parse_wish(options.recommend);
    seconds_of(options.budget);
    const fs::path folder = folder_of(study, options);
    try {
        for (const std::string& scene : study.scenes) {
            const fs::path own = study.scenes.size() == 1 ? folder : folder / fs::path(scene).stem();
            fs::create_directories(own);
            Tradeoff(study, options, scene, own).run();
        }
    } catch (const StudyInterrupted&) {
        fmt::print(stderr, "whorl: interrupted; points that are done are kept, the same command goes on\n");
        return exit_interrupted;
    }
    return exit_done;
}

}  // namespace

void add_tradeoff(CLI::App& program, Job& chosen) {
    const auto options = std::make_shared<SweepOptions>();
    CLI::App* app = program.add_subcommand("tradeoff", "sweep settings, measure what accuracy they buy and what they cost, draw the Pareto front");
    add_sweep_options(*app, *options);
    app->add_flag("--all", options->all, "run the whole grid, not only what the front may need");
    app->add_option("--recommend", options->recommend, "print the cheapest settings that reach it and write them as an overlay: \"error<2%\", \"fps>24\"")
        ->type_name("WISH");
    app->footer(
        "Each point is a run of its own process and is kept: a study that was stopped goes on when it is called again.\n"
        "Examples:\n"
        "  whorl tradeoff coil_frequency --budget 10min\n"
        "  whorl tradeoff coil_frequency --recommend \"error<5%\"\n"
        "  whorl render honey_coil --with out/coil_frequency/recommended.toml");
    app->callback([options, &chosen] { chosen = [options] { return tradeoff(*options); }; });
}

}  // namespace whorl
