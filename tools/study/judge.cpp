#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "engine/io/csv.h"
#include "render/image/image.h"
#include "tools/process/json_text.h"
#include "tools/study/point.h"

namespace whorl {
namespace {

namespace fs = std::filesystem;

/// Measured value, time and position of one row.
struct Sample {
    double t = 0;
    Vec3d x = Vec3d::Zero();
    double value = 0;
};

std::vector<Sample> samples_of(const AccuracyKeys& a, const fs::path& folder) {
    const CsvTable table = read_csv(folder / a.table);
    const std::size_t time = table.index("time"), column = table.index(a.column);
    std::vector<Sample> samples;
    for (const auto& row : table.rows) {
        if (row[time] < a.from || !std::isfinite(row[column])) continue;
        Sample s{row[time], Vec3d::Zero(), row[column]};
        for (int axis = 0; axis < 3; ++axis)
            if (const std::string name(1, "xyz"[axis]); table.has(name)) s.x[axis] = row[table.index(name)];
        samples.push_back(s);
    }
    return samples;
}

/// Relative error of the rows with respect to their expected values, by accuracy.at.
double compared(const AccuracyKeys& a, const std::vector<Sample>& samples, const std::vector<double>& expected) {
    if (samples.empty()) return std::numeric_limits<double>::quiet_NaN();
    double scale = a.scale;
    if (scale == 0)
        for (const double e : expected) scale = std::max(scale, std::abs(e));
    const std::size_t n = samples.size();
    double sum = 0;
    switch (a.at) {
        case Moment::last: return std::abs(samples.back().value - expected.back()) / (a.scale > 0 ? scale : std::abs(expected.back()));
        case Moment::mean:
            for (std::size_t k = 0; k < n; ++k) sum += samples[k].value - expected[k];
            return std::abs(sum) / static_cast<double>(n) / scale;
        case Moment::all:
            for (std::size_t k = 0; k < n; ++k) sum += std::pow(samples[k].value - expected[k], 2);
            return std::sqrt(sum / static_cast<double>(n)) / scale;
    }
    return 0;
}

fs::path last_picture(const fs::path& folder) {
    std::vector<fs::path> all;
    std::error_code none;
    for (const auto& entry : fs::directory_iterator(folder / "frames", none))
        if (entry.path().extension() == ".png") all.push_back(entry.path());
    if (all.empty()) throw InputError({folder.string(), 0, 0}, "the run has no PNG images to compare");
    return *std::max_element(all.begin(), all.end());
}

/// Largest growth of the total of kinetic, potential and spin energy since the start of the run, relative to the energy in motion. The
/// latter is the largest of `scale`, the initial kinetic and spin energy, and the change of potential energy so far.
struct Growth {
    double most = 0;
    const std::vector<double>* first = nullptr;  ///< first row above the allowed growth
};
Growth energy_growth(const CsvTable& table, double allowed, double scale) {
    const std::size_t kinetic = table.index("kinetic_energy"), potential = table.index("potential_energy"),
                      spin = table.index("spin_energy");
    const auto value = [](double v) { return std::isfinite(v) ? v : 0; };
    const auto& start = table.rows.front();
    const double e0 = value(start[kinetic]) + value(start[potential]) + value(start[spin]);
    Growth growth;
    double moved = std::max(scale, value(start[kinetic]) + value(start[spin]));
    for (const auto& row : table.rows) {
        moved = std::max(moved, std::abs(value(start[potential]) - value(row[potential])));
        const double more = value(row[kinetic]) + value(row[potential]) + value(row[spin]) - e0;
        growth.most = std::max(growth.most, more > 0 ? more / std::max(moved, 1e-9 * more) : 0);
        if (!growth.first && growth.most > allowed) growth.first = &row;
    }
    return growth;
}

/// Verdict with time, step and report of the first problem of a kind, from run.json.
Verdict first_trouble(const nlohmann::json& run, const std::string& kind, const std::string& state, const std::string& why) {
    Verdict verdict{state, why, 0, 0};
    for (const auto& trouble : run.value("first_troubles", nlohmann::json::array()))
        if (trouble.value("kind", "") == kind) {
            verdict.time = trouble.value("time", 0.0), verdict.step = trouble.value("step", 0L);
            const std::string what = trouble.value("what", "");
            if (why.find(what) == std::string::npos) verdict.why += (why.empty() ? "" : "; first: ") + what;
        }
    return verdict;
}

}  // namespace

double error_of(const AccuracyKeys& a, const fs::path& folder, const fs::path& reference) {
    if (a.of == AccuracyKind::picture) return difference(read_png(last_picture(folder)), read_png(last_picture(reference))).mean;
    const std::vector<Sample> samples = samples_of(a, folder);
    if (samples.empty()) return std::numeric_limits<double>::quiet_NaN();
    std::vector<double> expected;
    if (a.of == AccuracyKind::reference) {
        // The reference's rows are interpolated in time if the two runs write at different times.
        const std::vector<Sample> truth = samples_of(a, reference);
        if (truth.empty()) return std::numeric_limits<double>::quiet_NaN();
        for (const Sample& s : samples) {
            const auto after = std::lower_bound(truth.begin(), truth.end(), s.t, [](const Sample& r, double t) { return r.t < t; });
            const Sample& b = after == truth.end() ? truth.back() : *after;
            const Sample& c = after == truth.begin() ? truth.front() : *(after - 1);
            const double part = b.t > c.t ? std::clamp((s.t - c.t) / (b.t - c.t), 0.0, 1.0) : 0;
            expected.push_back(c.value + part * (b.value - c.value));
        }
    } else {
        for (const Sample& s : samples) expected.push_back(a.of == AccuracyKind::conserved ? samples.front().value : a.expected(s.t, s.x));
    }
    return compared(a, samples, expected);
}

Verdict judge(const StabilityKeys& keys, const PointResult& result) {
    if (result.status == "timeout" || result.status == "refused") return {result.status, result.message, 0, 0};
    const nlohmann::json run = json_of(result.folder / "run.json");
    if (result.status == "diverged" && run.is_object()) return first_trouble(run, "diverged", "diverged", result.message);
    if (!result.done() || !run.is_object()) return {"failed", result.message, 0, 0};
    const CsvTable table = read_csv(result.folder / "diagnostics.csv");
    if (table.rows.empty()) return {"failed", "the run wrote no diagnostics", 0, 0};
    const auto at_row = [&](const std::vector<double>& row, const char* state, std::string why) {
        return Verdict{state, std::move(why), row[table.index("time")], static_cast<long>(row[table.index("steps")])};
    };
    if (const long lost = run.value("lost_particles", 0L); lost > 0)
        return first_trouble(run, "lost", "lost particles",
                             fmt::format("{} of {} left the domain", lost, lost + run.value("particles", 0L)));
    if (keys.energy_growth > 0)
        if (const Growth growth = energy_growth(table, keys.energy_growth, std::strtod(keys.energy_scale.c_str(), nullptr)); growth.first)
            return at_row(*growth.first, "unphysical energy",
                          fmt::format("energy grew by {:.3g} % of the energy in motion", 100 * growth.most));
    const double steps = std::max(1.0, run.value("steps", 1.0));
    if (const double stalled = run.value("unconverged_solves", 0.0) / steps; stalled > keys.stalled)
        return first_trouble(run, "unconverged", "stalled solver",
                             fmt::format("{:.0f} % of the solves ended without convergence", 100 * stalled));
    if (keys.noisy_speed.empty()) return {"stable", "", 0, 0};
    const double allowed = std::strtod(keys.noisy_speed.c_str(), nullptr);
    if (const auto& last = table.rows.back(); last[table.index("max_speed")] > allowed)
        return at_row(last, "noisy",
                      fmt::format("fastest particle {:.3g} m/s at the end, {:.3g} m/s allowed", last[table.index("max_speed")], allowed));
    return {"stable", "", 0, 0};
}

}  // namespace whorl
