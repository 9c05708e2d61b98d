#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "engine/core/clock.h"
#include "engine/simulation/simulation.h"
#include "tools/film/progress.h"
#include "tools/program/command.h"
#include "tools/program/sweep.h"
#include "tools/scene_file/scene_file.h"
#include "tools/study/plot.h"

namespace whorl {
namespace {

using Json = nlohmann::ordered_json;

constexpr double not_measured = std::numeric_limits<double>::quiet_NaN();

struct Cell {
    Verdict verdict;
    double largest_stable = not_measured;  ///< largest stable value of the bisected key; NaN: no key is bisected, or no value is stable
    std::map<std::string, double> limits;  ///< time steps that the models allow at the start [s], by name of the limit
};

/// Stability map of one scene of a study over two knobs. With one knob the map has one row; with three there is a map per value of the
/// third.
class StabilityMap {
public:
    explicit StabilityMap(const Sweep& sweep)
        : sweep_(sweep), study_(sweep.study), nx_(values(0).size()), ny_(values(1).size()), panels_(values(2).size()),
          cells_(nx_ * ny_ * panels_), was_run_(cells_.size(), false) {}

    void run() {
        const double began = wall_seconds();
        std::size_t started = 0, done = 0;
        sweep_.run([&](double) -> Sweep::Task {
            if (started == cells_.size()) return nullptr;
            const std::size_t k = started++;
            return [this, began, &done, k, measure = task(k)] {
                return [this, began, &done, k, cell = measure()] {
                    cells_[k] = cell, was_run_[k] = true, ++done;
                    const double spent = wall_seconds() - began;
                    report(k, done, spent / static_cast<double>(done) * static_cast<double>(cells_.size() - done));
                };
            };
        });
        if (started < cells_.size())
            sweep_.say(fmt::format("the budget of {} is used up; repeat the command to continue", sweep_.options.budget));
        write();
    }

private:
    const std::vector<std::string>& values(std::size_t knob) const {
        static const std::vector<std::string> one{""};
        return knob < study_.knobs.size() ? study_.knobs[knob].values : one;
    }
    bool bisects() const { return !study_.stability.bisect.empty(); }

    /// Settings of cell k. The first knob varies fastest, the third slowest.
    std::vector<std::string> settings(std::size_t k) const {
        GridPoint p{static_cast<int>(k % nx_)};
        if (study_.knobs.size() > 1) p.push_back(static_cast<int>(k / nx_ % ny_));
        if (study_.knobs.size() > 2) p.push_back(static_cast<int>(k / nx_ / ny_));
        return settings_at(study_, p);
    }

    std::string note(const Cell& cell) const {
        if (!bisects() || cell.verdict.state == "refused") return cell.verdict.state;
        return std::isfinite(cell.largest_stable) ? fmt::format("to {:.3g}", cell.largest_stable) : "never stable";
    }

    void report(std::size_t k, std::size_t done, double left) const {
        const Verdict& v = cells_[k].verdict;
        sweep_.say(fmt::format("cell {} of {}: {}: {}{} (about {} left)", done, cells_.size(), joined_settings(settings(k)),
                               note(cells_[k]), v.why.empty() ? "" : ": " + v.why, duration(left)));
    }

    /// Time steps that the models allow at the start [s]. @throws InputError if the plan refuses the scene
    std::map<std::string, double> limits_of(const std::vector<std::string>& settings) const {
        const Scene scene = read_scene_file(point_call(study_, sweep_.scene, settings).options).scene;
        const Simulation simulation(scene, make_plan(scene));
        std::map<std::string, double> limits;
        const double fastest = largest_speed(simulation.world());
        for (const StepLimit& limit : simulation.assembly().limits)
            if (const double dt = limit.dt(simulation.world(), fastest); dt > 0 && std::isfinite(dt) && limit.name != "max_step")
                limits[limit.name] = dt;
        return limits;
    }

    std::function<Cell()> task(std::size_t k) const {
        Cell empty;
        std::vector<std::string> all = settings(k);
        if (bisects()) all.push_back(fmt::format("{}={:.6g}", study_.stability.bisect, study_.stability.low));
        try {
            empty.limits = limits_of(all);
        } catch (const InputError& error) {
            // If the point runs another program, that one may accept the scene: positions in double precision reach
            // farther from the origin.
            if (point_call(study_, sweep_.scene, all).program.empty()) {
                empty.verdict = {"refused", error.what(), 0, 0};
                return [empty] { return empty; };
            }
        }
        return [this, k, empty] { return bisects() ? bisected(settings(k), empty) : cell(settings(k), empty); };
    }

    Cell cell(const std::vector<std::string>& settings, Cell cell) const {
        StabilityKeys keys = study_.stability;
        for (std::string* text : {&keys.noisy_speed, &keys.energy_scale})
            if (!text->empty()) *text = with_values("{" + *text + "}", settings);
        cell.verdict = judge(keys, sweep_.point(settings, 1, false));
        return cell;
    }

    /// Cell with the largest stable value of the bisected key, found by bisection on a logarithmic scale.
    Cell bisected(const std::vector<std::string>& settings, const Cell& empty) const {
        const StabilityKeys& s = study_.stability;
        const auto at = [&](double value) {
            std::vector<std::string> all = settings;
            all.push_back(fmt::format("{}={:.6g}", s.bisect, value));
            return cell(all, empty);
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
            else
                b = middle,
                low.verdict.why = fmt::format("{} = {:.3g} is {}: {}", s.bisect, middle, tried.verdict.state, tried.verdict.why);
        }
        return low;
    }

    /// Position of a value on the second knob's axis: 0 at its first value, half a cell more at both ends; NaN outside.
    double place_of(double value) const {
        std::vector<double> at;
        for (const std::string& v : values(1)) at.push_back(std::log(std::max(1e-300, std::strtod(v.c_str(), nullptr))));
        const double wanted = std::log(value);
        for (std::size_t j = 0; j + 1 < at.size(); ++j) {
            const double place = static_cast<double>(j) + (wanted - at[j]) / (at[j + 1] - at[j]);
            const double from = j == 0 ? -0.5 : static_cast<double>(j), to = static_cast<double>(j) + (j + 2 == at.size() ? 1.5 : 1.0);
            if (place >= from && place <= to) return place;
        }
        return not_measured;
    }

    /// Lines of the limits that the study predicts, and of the models' limits if the second knob is the time step.
    std::vector<MapLimit> predicted(std::size_t panel) const {
        std::map<std::string, MapLimit> found;
        const auto add = [&](const std::string& name, std::size_t i, double value) {
            found.try_emplace(name, MapLimit{name, std::vector<double>(nx_, not_measured)}).first->second.place[i] = place_of(value);
        };
        if (ny_ < 2) return {};
        const std::string& y = study_.knobs[1].key;
        for (std::size_t i = 0; i < nx_; ++i) {
            const std::size_t first = i + panel * nx_ * ny_;
            if (y == "time.fixed_step" || y == "dt")
                for (const auto& [name, dt] : cells_[first].limits) add(name, i, dt);
            for (const LimitKeys& limit : study_.stability.limits) {
                std::vector<std::string> known = settings(first);
                known.push_back("x=" + values(0)[i]);
                add(limit.name, i, std::strtod(with_values("{" + limit.value + "}", known).c_str(), nullptr));
            }
        }
        std::vector<MapLimit> all;
        for (auto& [name, limit] : found)
            if (std::any_of(limit.place.begin(), limit.place.end(), [](double p) { return std::isfinite(p); })) all.push_back(limit);
        return all;
    }

    Canvas map() const {
        std::vector<StabilityPanel> panels;
        for (std::size_t p = 0; p < panels_; ++p) {
            StabilityPanel panel{panels_ > 1 ? study_.knobs[2].title() + " = " + values(2)[p] : "", {}, predicted(p)};
            for (std::size_t k = p * nx_ * ny_; k < (p + 1) * nx_ * ny_; ++k)
                panel.cells.push_back(was_run_[k] ? MapCell{cells_[k].verdict.state, bisects() ? note(cells_[k]) : ""}
                                                  : MapCell{"not run", ""});
            panels.push_back(std::move(panel));
        }
        const std::string title = study_.name + (bisects() ? ": largest stable " + study_.stability.bisect : "");
        return draw_maps(panels, values(0), values(1), title, study_.knobs[0].title(),
                         study_.knobs.size() > 1 ? study_.knobs[1].title() : "");
    }

    void write() const {
        std::map<std::string, int> count;
        Json rows = Json::array();
        for (std::size_t k = 0; k < cells_.size(); ++k) {
            if (!was_run_[k]) continue;
            const Cell& c = cells_[k];
            const Verdict& v = c.verdict;
            ++count[v.state];
            rows.push_back({{"settings", settings(k)},
                            {"state", v.state},
                            {"largest_stable", c.largest_stable},
                            {"first_bad_time", v.step > 0 ? Json(v.time) : Json()},
                            {"first_bad_step", v.step > 0 ? Json(v.step) : Json()},
                            {"limits", c.limits},
                            {"why", v.why}});
        }
        sweep_.write("stability", map(), {"state", "largest_stable", "first_bad_time", "first_bad_step", "limits", "why"}, "cells", rows);
        std::vector<std::string> sums;
        for (const auto& [state, n] : count) sums.push_back(fmt::format("{} {}", n, state));
        sweep_.say(fmt::format("{}; {}/stability.csv, stability.png, stability.svg", fmt::join(sums, ", "), sweep_.folder.string()));
    }

    const Sweep& sweep_;
    const Study& study_;
    std::size_t nx_, ny_, panels_;
    std::vector<Cell> cells_;
    std::vector<bool> was_run_;
};

int run_stability(const SweepOptions& options) {
    const Study study = read_study(options.study);
    if (study.knobs.empty() || study.knobs.size() > 3)
        throw InputError({options.study, 0, 0}, fmt::format("a stability map has 1 to 3 knobs; this study has {}", study.knobs.size()),
                         "remove a knob, or set stability.bisect to search for its largest stable value");
    return run_sweeps(study, options, false, [](const Sweep& sweep) { StabilityMap(sweep).run(); });
}

}  // namespace

void add_stability(CLI::App& program, Job& chosen) {
    const auto [app, o] =
        add_command(program, chosen, "stability",
                    "run a scene with extreme settings and draw a map of the stable ones with the predicted limits", run_stability,
                    "Each cell is a run in a separate process. Finished cells are kept: repeat the command to continue a stopped map.\n"
                    "Cells that failed, or whose scene was edited since, are run again.\n"
                    "time.fixed_step overrides the limits of the models, so a map over it tests these limits.\n"
                    "Examples:\n"
                    "  whorl stability viscous_steps\n"
                    "  whorl stability my_map.toml --budget 20min --out maps/mine\n"
                    "  whorl stability viscous_steps --on slurm --jobs 20");
    add_sweep_options(app, o);
}

}  // namespace whorl
