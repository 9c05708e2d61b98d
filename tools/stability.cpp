#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "engine/core/clock.h"
#include "engine/core/whole_file.h"
#include "engine/sim/simulation.h"
#include "tools/command.h"
#include "tools/options.h"
#include "tools/run/progress.h"
#include "tools/study/plot.h"
#include "tools/study/stability.h"
#include "tools/study/sweep.h"

namespace whorl {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct Cell {
    Verdict verdict;
    double largest_stable = NAN;              ///< of the bisected key; NaN: none was, or nothing is stable
    std::map<std::string, double> limits;     ///< s, the time steps that the models allow at the start, from the plan
};

const std::string fixed_step = "time.fixed_step";

/// One scene of a study, swept over two knobs (one: a map of one row).
class StabilityMap {
public:
    StabilityMap(const Study& study, const SweepOptions& options, std::string scene, fs::path folder)
        : study_(study), options_(options), scene_(std::move(scene)), folder_(std::move(folder)), runner_(study, folder_, options.threads),
          nx_(study.knobs[0].values.size()), ny_(study.knobs.size() > 1 ? study.knobs[1].values.size() : 1) {}

    /// @return number of cells that are not stable
    long run() {
        const double began = wall_seconds(), budget = seconds_of(options_.budget);
        for (std::size_t k = 0; k < nx_ * ny_; ++k) {
            if (budget > 0 && wall_seconds() - began > budget) {
                say(fmt::format("the budget of {} is spent; the same command goes on from here", options_.budget));
                break;
            }
            cells_.push_back(study_.stability.bisect.empty() ? cell(settings(k)) : bisected(settings(k)));
            const double left = (wall_seconds() - began) / static_cast<double>(k + 1) * static_cast<double>(nx_ * ny_ - k - 1);
            say(fmt::format("cell {} of {}: {}: {}{} ({} left)", k + 1, nx_ * ny_, joined_settings(settings(k)), note(cells_.back()),
                            cells_.back().verdict.why.empty() ? "" : ": " + cells_.back().verdict.why, duration(left)));
        }
        write();
        return std::count_if(cells_.begin(), cells_.end(), [](const Cell& c) { return !c.verdict.stable() && c.verdict.state != "refused"; });
    }

private:
    void say(const std::string& text) const {
        if (!options_.json) fmt::print("{}\n", text), std::fflush(stdout);
    }
    bool bisects() const { return !study_.stability.bisect.empty(); }

    std::vector<std::string> settings(std::size_t k) const {
        GridPoint p{static_cast<int>(k % nx_)};
        if (study_.knobs.size() > 1) p.push_back(static_cast<int>(k / nx_));
        return settings_at(study_, p);
    }

    std::string note(const Cell& cell) const {
        if (!bisects() || cell.verdict.state == "refused") return cell.verdict.state;
        return std::isfinite(cell.largest_stable) ? fmt::format("to {:.3g}", cell.largest_stable) : "nowhere stable";
    }

    /// What the models allow at the start. @throws InputError where the plan refuses the scene
    std::map<std::string, double> limits_of(const std::vector<std::string>& settings) const {
        Options options;
        options.scene = scene_, options.quality = study_.quality;
        options.set = study_.set;
        options.set.insert(options.set.end(), settings.begin(), settings.end());
        const SceneFile file = read_scene_file(options);
        const Plan plan = make_plan(file.scene);
        const Simulation simulation(file.scene, plan);
        std::map<std::string, double> limits;
        const double fastest = largest_speed(simulation.world());
        for (const StepLimit& limit : simulation.assembly().limits)
            if (const double dt = limit.dt(simulation.world(), fastest); dt > 0 && std::isfinite(dt) && limit.name != "max_step") limits[limit.name] = dt;
        return limits;
    }

    Cell cell(const std::vector<std::string>& settings) const {
        Cell cell;
        try {
            cell.limits = limits_of(settings);
            cell.verdict = judge(study_.stability, runner_.run(scene_, settings, 1, false));
        } catch (const InputError& error) {
            cell.verdict = {"refused", error.what()};
        }
        return cell;
    }

    /// The largest value of the bisected key that is stable, on a logarithmic scale.
    Cell bisected(const std::vector<std::string>& settings) const {
        const StabilityKeys& s = study_.stability;
        const auto at = [&](double value) {
            std::vector<std::string> all = settings;
            all.push_back(fmt::format("{}={:.6g}", s.bisect, value));
            return cell(all);
        };
        Cell low = at(s.low);
        if (!low.verdict.stable()) return low;
        low.largest_stable = s.low;
        Cell high = at(s.high);
        if (high.verdict.stable()) return high.largest_stable = s.high, high;
        double a = s.low, b = s.high;
        for (int k = 0; k < s.halvings; ++k) {
            const double middle = std::sqrt(a * b);
            const Cell tried = at(middle);
            if (tried.verdict.stable()) a = middle, low.largest_stable = middle;
            else b = middle, low.verdict.why = fmt::format("{} = {:.3g} is {}: {}", s.bisect, middle, tried.verdict.state, tried.verdict.why);
        }
        return low;
    }

    /// Where the predicted limits cross the map: only where its second knob is the time step itself.
    std::vector<MapLimit> predicted() const {
        std::map<std::string, MapLimit> limits;
        if (ny_ < 2 || study_.knobs[1].key != fixed_step) return {};
        std::vector<double> steps;
        for (const std::string& v : study_.knobs[1].values) steps.push_back(std::log(std::max(1e-300, std::strtod(v.c_str(), nullptr))));
        for (std::size_t i = 0; i < nx_ && i < cells_.size(); ++i)
            for (const auto& [name, dt] : cells_[i].limits) {
                MapLimit& limit = limits.try_emplace(name, MapLimit{name, std::vector<double>(nx_, NAN)}).first->second;
                const double wanted = std::log(dt);
                for (std::size_t j = 0; j + 1 < steps.size(); ++j)
                    if ((wanted - steps[j]) * (wanted - steps[j + 1]) <= 0)
                        limit.place[i] = static_cast<double>(j) + (wanted - steps[j]) / (steps[j + 1] - steps[j]);
            }
        std::vector<MapLimit> all;
        for (auto& [name, limit] : limits)
            if (std::any_of(limit.place.begin(), limit.place.end(), [](double p) { return std::isfinite(p); })) all.push_back(limit);
        return all;
    }

    void write() const {
        std::string csv;
        for (const Knob& knob : study_.knobs) csv += csv_cell(knob.key) + ",";
        csv += "state,largest_stable,limits,why\n";
        std::vector<MapCell> drawn;
        for (std::size_t k = 0; k < nx_ * ny_; ++k) {
            if (k >= cells_.size()) {
                drawn.push_back({"not run", ""});
                continue;
            }
            const Cell& c = cells_[k];
            for (const std::string& setting : settings(k)) csv += csv_cell(setting.substr(setting.find('=') + 1)) + ",";
            std::string limits;
            for (const auto& [name, dt] : c.limits) limits += fmt::format("{}{} {:.3g}", limits.empty() ? "" : "; ", name, dt);
            csv += fmt::format("{},{},{},{}\n", c.verdict.state, std::isfinite(c.largest_stable) ? fmt::format("{:.4g}", c.largest_stable) : "", csv_cell(limits),
                               csv_cell(c.verdict.why));
            drawn.push_back({c.verdict.state, bisects() ? note(c) : ""});
        }
        write_text(folder_ / "stability.csv", csv);
        const std::vector<std::string> one{""};
        const bool two = study_.knobs.size() > 1;
        const std::string title = study_.name + (bisects() ? ": largest stable " + study_.stability.bisect : "");
        const Canvas canvas = draw_map(study_.knobs[0].values, two ? study_.knobs[1].values : one, drawn, predicted(), title, study_.knobs[0].key,
                                       two ? study_.knobs[1].key : "");
        write_png(folder_ / "stability.png", canvas.image());
        write_text(folder_ / "stability.svg", canvas.svg());
        std::map<std::string, int> count;
        for (const Cell& c : cells_) ++count[c.verdict.state];
        std::string sums;
        for (const auto& [state, n] : count) sums += fmt::format("{}{} {}", sums.empty() ? "" : ", ", n, state);
        say(fmt::format("{}; {}/stability.csv, stability.png, stability.svg", sums, folder_.string()));
        if (!options_.json) return;
        Json cells = Json::array();
        for (std::size_t k = 0; k < cells_.size(); ++k)
            cells.push_back({{"settings", settings(k)}, {"state", cells_[k].verdict.state}, {"why", cells_[k].verdict.why},
                             {"largest_stable", std::isfinite(cells_[k].largest_stable) ? Json(cells_[k].largest_stable) : Json()}, {"limits", cells_[k].limits}});
        fmt::print("{}\n", Json{{"study", study_.name}, {"scene", scene_}, {"folder", folder_.string()}, {"cells", cells}}.dump(2));
    }

    const Study& study_;
    const SweepOptions& options_;
    std::string scene_;
    fs::path folder_;
    PointRunner runner_;
    std::size_t nx_, ny_;
    std::vector<Cell> cells_;
};

int stability(const SweepOptions& options) {
    const Study study = read_study(options.study);
    if (study.knobs.empty() || study.knobs.size() > 2)
        throw InputError({options.study, 0, 0}, fmt::format("a map has one knob or two, this study has {}", study.knobs.size()), "a third one can be searched for: stability.bisect");
    seconds_of(options.budget);
    const fs::path folder = folder_of(study, options);
    try {
        for (const std::string& scene : study.scenes) {
            const fs::path own = study.scenes.size() == 1 ? folder : folder / fs::path(scene).stem();
            fs::create_directories(own);
            StabilityMap(study, options, scene, own).run();
        }
    } catch (const StudyInterrupted&) {
        fmt::print(stderr, "whorl: interrupted; cells that are done are kept, the same command goes on\n");
        return exit_interrupted;
    }
    return exit_done;
}

}  // namespace

void add_stability(CLI::App& program, Job& chosen) {
    const auto options = std::make_shared<SweepOptions>();
    CLI::App* app = program.add_subcommand("stability", "push settings to the extremes and draw the map of what stays stable, with the predicted limits on it");
    add_sweep_options(*app, *options);
    app->footer(
        "Each cell is a run of its own process and is kept: a map that was stopped goes on when it is called again.\n"
        "time.fixed_step sets the time step and ignores what the models allow: the map shows whether they are right.\n"
        "Examples:\n"
        "  whorl stability viscous_steps\n"
        "  whorl stability my_map.toml --budget 20min --out maps/mine");
    app->callback([options, &chosen] { chosen = [options] { return stability(*options); }; });
}

}  // namespace whorl
