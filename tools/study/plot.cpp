#include "tools/study/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace whorl {
namespace {

const Vec3f ink(0.13f, 0.13f, 0.16f), faint(0.86f, 0.86f, 0.88f), grey(0.60f, 0.60f, 0.64f), accent(0.78f, 0.36f, 0.05f);

/// A logarithmic axis with a margin, and its marks: 1, 2 and 5 in every decade, or only 1 where there are many.
struct LogAxis {
    double low, high, from, to;  ///< values, pixels
    LogAxis(const std::vector<double>& values, double first, double last) : from(first), to(last) {
        low = std::numeric_limits<double>::infinity(), high = 0;
        for (const double v : values)
            if (std::isfinite(v) && v > 0) low = std::min(low, v), high = std::max(high, v);
        if (!(high > 0)) low = 0.1, high = 10;
        const double margin = std::pow(std::max(1.3, high / low), 0.08);
        low /= margin, high *= margin;
    }
    double at(double v) const { return from + (to - from) * std::log(v / low) / std::log(high / low); }
    std::vector<double> marks() const {
        std::vector<double> all;
        const bool few = std::log10(high / low) < 3;
        for (int decade = static_cast<int>(std::floor(std::log10(low))); decade <= std::ceil(std::log10(high)); ++decade)
            for (const double step : few ? std::vector<double>{1, 2, 5} : std::vector<double>{1})
                if (const double v = step * std::pow(10, decade); v >= low && v <= high) all.push_back(v);
        return all;
    }
};

Vec3f colour_of(const std::string& state) {
    static const std::map<std::string, Vec3f> colours{
        {"stable", Vec3f(0.72f, 0.87f, 0.72f)},        {"noisy", Vec3f(0.98f, 0.90f, 0.62f)},      {"diverged", Vec3f(0.90f, 0.52f, 0.48f)},
        {"lost particles", Vec3f(0.93f, 0.70f, 0.55f)}, {"stalled solver", Vec3f(0.76f, 0.73f, 0.90f)}, {"unphysical energy", Vec3f(0.95f, 0.76f, 0.80f)},
        {"timeout", Vec3f(0.80f, 0.80f, 0.82f)},       {"refused", Vec3f(0.92f, 0.92f, 0.93f)}};
    const auto found = colours.find(state);
    return found == colours.end() ? Vec3f(0.8f, 0.8f, 0.82f) : found->second;
}

}  // namespace

Canvas draw_front(const std::vector<PlotPoint>& points, const std::string& title, const std::string& x_name, const std::string& y_name) {
    constexpr int width = 900, height = 560, left = 90, right = 40, top = 56, low = 64;
    Canvas c(width, height);
    std::vector<double> xs, ys;
    for (const PlotPoint& p : points) xs.insert(xs.end(), {p.x, p.x_low, p.x_high}), ys.push_back(p.y);
    const LogAxis x(xs, left, width - right), y(ys, height - low, top);
    c.words(left, 30, title, ink, 17);
    for (const double v : x.marks()) {
        c.line(x.at(v), top, x.at(v), height - low, faint);
        c.words(x.at(v), height - low + 20, fmt::format("{:g}", v), ink, 13, 0);
    }
    for (const double v : y.marks()) {
        c.line(left, y.at(v), width - right, y.at(v), faint);
        c.words(left - 8, y.at(v) + 5, fmt::format("{:g}", v), ink, 13, 1);
    }
    c.line(left, height - low, width - right, height - low, ink), c.line(left, top, left, height - low, ink);
    c.words(0.5 * (left + width - right), height - 18, x_name, ink, 14, 0);
    c.words(left, top - 8, y_name, ink, 14);
    const PlotPoint* before = nullptr;
    for (const PlotPoint& p : points) {
        if (!p.on_front) continue;
        if (before) c.line(x.at(before->x), y.at(before->y), x.at(p.x), y.at(p.y), accent, 2);
        before = &p;
    }
    for (const PlotPoint& p : points) {
        if (!(p.x > 0) || !(p.y > 0)) continue;
        const Vec3f colour = p.on_front ? accent : grey;
        if (p.x_high > p.x_low) c.line(x.at(p.x_low), y.at(p.y), x.at(p.x_high), y.at(p.y), colour, 1.5);
        c.disc(x.at(p.x), y.at(p.y), p.on_front ? 5 : 3.5, colour);
    }
    for (const PlotPoint& p : points)  // labels last: on top
        if (p.on_front) c.words(std::min(x.at(p.x) + 9, width - right - 6.2 * static_cast<double>(p.label.size())), y.at(p.y) - 8, p.label, ink, 11);
    return c;
}

Canvas draw_map(const std::vector<std::string>& x_values, const std::vector<std::string>& y_values, const std::vector<MapCell>& cells,
                const std::vector<MapLimit>& limits, const std::string& title, const std::string& x_name, const std::string& y_name) {
    constexpr double cell_x = 96, cell_y = 44, left = 120, top = 64;
    const auto nx = static_cast<double>(x_values.size()), ny = static_cast<double>(y_values.size());
    const double right = left + cell_x * nx, low = top + cell_y * ny;
    std::vector<std::string> states;
    for (const MapCell& cell : cells)
        if (std::find(states.begin(), states.end(), cell.state) == states.end()) states.push_back(cell.state);
    Canvas c(static_cast<int>(std::max(right + 40, 560.0)), static_cast<int>(low + 78 + 22 * static_cast<double>((states.size() + 2) / 3 + limits.size())));
    c.words(20, 30, title, ink, 17);
    c.words(20, top - 10, y_name, ink, 13);
    for (std::size_t j = 0; j < y_values.size(); ++j) {
        const double y = low - cell_y * static_cast<double>(j + 1);
        c.words(left - 8, y + 0.5 * cell_y + 5, y_values[j], ink, 13, 1);
        for (std::size_t i = 0; i < x_values.size(); ++i) {
            const MapCell& cell = cells[j * x_values.size() + i];
            const double x = left + cell_x * static_cast<double>(i);
            c.box(x + 1, y + 1, cell_x - 2, cell_y - 2, colour_of(cell.state));
            c.words(x + 0.5 * cell_x, y + 0.5 * cell_y + 4, cell.note, ink, 11, 0);
        }
    }
    for (std::size_t i = 0; i < x_values.size(); ++i) c.words(left + cell_x * (static_cast<double>(i) + 0.5), low + 18, x_values[i], ink, 13, 0);
    c.words(0.5 * (left + right), low + 40, x_name, ink, 13, 0);
    static const Vec3f lines[] = {Vec3f(0.10f, 0.25f, 0.60f), Vec3f(0.55f, 0.10f, 0.45f), Vec3f(0.05f, 0.45f, 0.40f), Vec3f(0.35f, 0.25f, 0.10f)};
    for (std::size_t k = 0; k < limits.size(); ++k) {
        const MapLimit& limit = limits[k];
        const auto y_of = [&](double place) { return low - cell_y * (place + 0.5); };
        for (std::size_t i = 0; i < limit.place.size(); ++i) {
            if (!std::isfinite(limit.place[i])) continue;
            const double x = left + cell_x * static_cast<double>(i), y = std::clamp(y_of(limit.place[i]), top, low);
            c.line(x + 4, y, x + cell_x - 4, y, lines[k % 4], 2.5);
        }
        const double y = low + 64 + 22 * static_cast<double>((states.size() + 2) / 3 + k);
        c.line(30, y - 4, 60, y - 4, lines[k % 4], 2.5);
        c.words(70, y, "predicted limit: " + limit.name, ink, 12);
    }
    for (std::size_t k = 0; k < states.size(); ++k) {
        const double x = 30 + 180 * static_cast<double>(k % 3), y = low + 64 + 22 * static_cast<double>(k / 3);
        c.box(x, y - 12, 26, 15, colour_of(states[k]));
        c.words(x + 34, y, states[k], ink, 12);
    }
    return c;
}

}  // namespace whorl
