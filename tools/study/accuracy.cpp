#include "tools/study/accuracy.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/io/csv.h"
#include "render/image/difference.h"
#include "render/image/image.h"

namespace whorl {
namespace {

namespace fs = std::filesystem;

/// One row that counts: what was measured, and where.
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

/// The error over the rows, each against its own expected value.
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
    if (all.empty()) throw InputError({folder.string(), 0, 0}, "the run has no PNG pictures to compare");
    return *std::max_element(all.begin(), all.end());
}

}  // namespace

double error_of(const AccuracyKeys& a, const fs::path& folder, const fs::path& reference) {
    if (a.of == AccuracyKind::picture) return difference(read_png(last_picture(folder)), read_png(last_picture(reference))).mean;
    const std::vector<Sample> samples = samples_of(a, folder);
    if (samples.empty()) return std::numeric_limits<double>::quiet_NaN();
    std::vector<double> expected;
    if (a.of == AccuracyKind::reference) {
        // Row by row where both runs write the same times; the reference's rows are interpolated in time otherwise.
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

}  // namespace whorl
