#include "tools/study/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace whorl {
namespace {

const Vec3f ink(0.13f, 0.13f, 0.16f), faint(0.86f, 0.86f, 0.88f), grey(0.60f, 0.60f, 0.64f), accent(0.78f, 0.36f, 0.05f);

/// A logarithmic axis with a margin. It has a mark at every power of ten, or more marks per decade if that gives fewer than three.
struct LogAxis {
    double low, high, from, to;  ///< range of values; its ends in pixels
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
        static const std::vector<std::vector<double>> steps{{1}, {1, 2, 5}, {1, 1.5, 2, 3, 4, 5, 6, 7, 8, 9}};
        for (const std::vector<double>& some : steps) {  // the first that gives three marks
            std::vector<double> all;
            for (int decade = static_cast<int>(std::floor(std::log10(low))); decade <= std::ceil(std::log10(high)); ++decade)
                for (const double step : some)
                    if (const double v = step * std::pow(10, decade); v >= low && v <= high) all.push_back(v);
            if (all.size() >= 3) return all;
        }
        return {low, std::sqrt(low * high), high};
    }
};

Vec3f colour_of(const std::string& state) {
    static const std::map<std::string, Vec3f> colours{
        {"stable", Vec3f(0.72f, 0.87f, 0.72f)},         {"noisy", Vec3f(0.98f, 0.90f, 0.62f)},
        {"diverged", Vec3f(0.90f, 0.52f, 0.48f)},       {"lost particles", Vec3f(0.93f, 0.70f, 0.55f)},
        {"stalled solver", Vec3f(0.76f, 0.73f, 0.90f)}, {"unphysical energy", Vec3f(0.95f, 0.76f, 0.80f)},
        {"timeout", Vec3f(0.80f, 0.80f, 0.82f)},        {"refused", Vec3f(0.92f, 0.92f, 0.93f)}};
    const auto found = colours.find(state);
    return found == colours.end() ? Vec3f(0.8f, 0.8f, 0.82f) : found->second;
}

Vec3f line_colour(std::size_t k) {
    static const Vec3f lines[] = {Vec3f(0.10f, 0.25f, 0.60f), Vec3f(0.55f, 0.10f, 0.45f), Vec3f(0.05f, 0.45f, 0.40f),
                                  Vec3f(0.35f, 0.25f, 0.10f)};
    return lines[k % 4];
}

}  // namespace

Canvas draw_front(const std::vector<PlotPoint>& points, const std::string& title, const std::string& x_name, const std::string& y_name) {
    constexpr int width = 900, height = 560, left = 90, right = 40, top = 56, low = 64;
    Canvas c(width, height);
    std::vector<double> xs, ys;
    for (const PlotPoint& p : points) xs.insert(xs.end(), {p.x, p.x_low, p.x_high}), ys.push_back(p.y);
    const LogAxis x(xs, left, width - right), y(ys, height - low, top);
    c.words(left, 26, title, ink, 17);
    for (const double v : x.marks()) {
        c.line(x.at(v), top, x.at(v), height - low, faint);
        c.words(x.at(v), height - low + 20, fmt::format("{:.3g}", v), ink, 13, 0);
    }
    for (const double v : y.marks()) {
        c.line(left, y.at(v), width - right, y.at(v), faint);
        c.words(left - 8, y.at(v) + 5, fmt::format("{:.3g}", v), ink, 13, 1);
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
    // Labels come last, on top. Each gets a free position next to its point, else farther up or down.
    struct Box {
        double x0, y0, x1, y1;
        bool meets(const Box& o) const { return x0 < o.x1 && o.x0 < x1 && y0 < o.y1 && o.y0 < y1; }
    };
    std::vector<Box> taken;
    for (const PlotPoint& p : points)
        if (p.on_front) taken.push_back({x.at(p.x) - 5, y.at(p.y) - 5, x.at(p.x) + 5, y.at(p.y) + 5});
    for (const PlotPoint& p : points) {
        if (!p.on_front) continue;
        const double wide = Canvas::width_of(p.label, 12) + 4, px = x.at(p.x), py = y.at(p.y);
        Box best{};
        for (const double step : {-10.0, 20.0, -26.0, 36.0, -42.0, 52.0, -58.0, 68.0})
            for (const double side : {8.0, -8 - wide}) {
                const double x0 = std::clamp(px + side, left + 2.0, width - right - wide), y0 = py + step;
                const Box box{x0, y0 - 11, x0 + wide, y0 + 3};
                const bool free = box.y0 > top && box.y1 < height - low &&
                                  std::none_of(taken.begin(), taken.end(), [&](const Box& t) { return box.meets(t); });
                if (free && best.x1 == 0) best = box;
            }
        if (best.x1 == 0) continue;  // no free position; the table contains the label
        c.words(best.x0 + 2, best.y1 - 3, p.label, ink, 12);
        taken.push_back(best);
    }
    return c;
}

namespace {

struct MapSize {
    double cell_x, cell_y, left = 74, right = 22, top = 30, low = 58;
};

void draw_panel(Canvas& c, const StabilityPanel& panel, const std::vector<std::string>& x_values, const std::vector<std::string>& y_values,
                const std::vector<std::string>& limit_names, const MapSize& size, double x0, double y0) {
    const double left = x0 + size.left, top = y0 + size.top, low = top + size.cell_y * static_cast<double>(y_values.size());
    c.words(left, top - 10, panel.title, ink, 14);
    for (std::size_t j = 0; j < y_values.size(); ++j) {
        const double y = low - size.cell_y * static_cast<double>(j + 1);
        c.words(left - 7, y + 0.5 * size.cell_y + 4, y_values[j], ink, 12, 1);
        for (std::size_t i = 0; i < x_values.size(); ++i) {
            const MapCell& cell = panel.cells[j * x_values.size() + i];
            const double x = left + size.cell_x * static_cast<double>(i);
            c.box(x + 1, y + 1, size.cell_x - 2, size.cell_y - 2, colour_of(cell.state));
            c.words(x + 0.5 * size.cell_x, y + 0.5 * size.cell_y + 4, cell.note, ink, 11, 0);
        }
    }
    for (std::size_t i = 0; i < x_values.size(); ++i)
        c.words(left + size.cell_x * (static_cast<double>(i) + 0.5), low + 17, x_values[i], ink, 12, 0);
    for (const MapLimit& limit : panel.limits) {
        const auto k = static_cast<std::size_t>(std::find(limit_names.begin(), limit_names.end(), limit.name) - limit_names.begin());
        for (std::size_t i = 0; i < limit.place.size(); ++i) {
            if (!std::isfinite(limit.place[i])) continue;
            const double x = left + size.cell_x * static_cast<double>(i),
                         y = std::clamp(low - size.cell_y * (limit.place[i] + 0.5), top, low);
            c.line(x + 3, y, x + size.cell_x - 3, y, line_colour(k), 2.5);
        }
    }
}

}  // namespace

Canvas draw_maps(const std::vector<StabilityPanel>& panels, const std::vector<std::string>& x_values,
                 const std::vector<std::string>& y_values, const std::string& title, const std::string& x_name, const std::string& y_name) {
    const std::size_t columns = std::min<std::size_t>(3, panels.size()), rows = (panels.size() + columns - 1) / columns;
    MapSize size{panels.size() > 1 ? 50.0 : 84.0, panels.size() > 1 ? 30.0 : 42.0};
    std::size_t longest = 0;
    for (const std::string& y : y_values) longest = std::max(longest, y.size());
    size.left = 30 + 8.0 * static_cast<double>(longest);
    std::vector<std::string> states, limits;
    const auto note = [](std::vector<std::string>& names, const std::string& name) {
        if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    };
    for (const StabilityPanel& panel : panels) {
        for (const MapCell& cell : panel.cells) note(states, cell.state);
        for (const MapLimit& limit : panel.limits) note(limits, limit.name);
    }
    const double panel_x = size.left + size.right + size.cell_x * static_cast<double>(x_values.size());
    const double panel_y = size.top + size.low + size.cell_y * static_cast<double>(y_values.size());
    const double width = std::max(panel_x * static_cast<double>(columns), 600.0), head = 70;
    const double legend = head + panel_y * static_cast<double>(rows);
    const auto legend_rows = static_cast<double>((states.size() + 2) / 3 + (limits.size() + 1) / 2);
    Canvas c(static_cast<int>(width), static_cast<int>(legend + 22 * legend_rows + 12));
    c.words(20, 28, title, ink, 17);
    c.words(20, 52, x_name + " to the right, " + (y_name.empty() ? "one row" : y_name + " upwards"), ink, 13);
    for (std::size_t k = 0; k < panels.size(); ++k)
        draw_panel(c, panels[k], x_values, y_values, limits, size, panel_x * static_cast<double>(k % columns),
                   head + panel_y * static_cast<double>(k / columns));
    double y = legend;
    for (std::size_t k = 0; k < states.size(); ++k) {
        const double x = 30 + 190 * static_cast<double>(k % 3);
        if (k > 0 && k % 3 == 0) y += 22;
        c.box(x, y - 12, 26, 15, colour_of(states[k]));
        c.words(x + 34, y, states[k], ink, 12);
    }
    y += 22;
    for (std::size_t k = 0; k < limits.size(); ++k) {
        const double x = 30 + 285 * static_cast<double>(k % 2);
        if (k > 0 && k % 2 == 0) y += 22;
        c.line(x, y - 4, x + 26, y - 4, line_colour(k), 2.5);
        c.words(x + 34, y, "predicted: " + limits[k], ink, 12);
    }
    return c;
}

}  // namespace whorl
