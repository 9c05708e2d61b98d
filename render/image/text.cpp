#include "render/image/text.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "render/image/linear_light.h"

namespace whorl {
namespace {

/// A letter is drawn with a round pen along strokes, divided by blanks. A stroke is a row of points, each a digit (x) and a letter (y: c on
/// the baseline, g the height of small letters, i that of capitals, a below). With "~" the points are the control polygon of a quadratic
/// B-spline that begins and ends in its ends, with "@" of a closed one.
struct Glyph {
    char name;
    float width;
    const char* strokes;
};
constexpr std::array glyphs{
    Glyph{'0', 4, "@0c0i4i4c"},
    Glyph{'1', 2, "0g2i2c"},
    Glyph{'2', 4, "~0g0i4i4f0c 0c4c"},
    Glyph{'3', 4, "~0h0i4i4f1f ~1f4f4c0c0d"},
    Glyph{'4', 4, "3c3i0e4e"},
    Glyph{'5', 4, "4i0i0f ~0f2g4g4c0c0d"},
    Glyph{'6', 4, "@0c0g4g4c ~0e0i3i4h"},
    Glyph{'7', 4, "0i4i1c"},
    Glyph{'8', 4, "@0f0i4i4f @0c0f4f4c"},
    Glyph{'9', 4, "@0e0i4i4e ~4g4c1c0d"},
    Glyph{'a', 4, "@0c0g4g4c 4g4c"},
    Glyph{'b', 4, "0i0c @0c0g4g4c"},
    Glyph{'c', 4, "~4f4g0g0c4c4d"},
    Glyph{'d', 4, "4i4c @0c0g4g4c"},
    Glyph{'e', 4, "0e4e ~4e4g0g0c3c4d"},
    Glyph{'f', 3, "~3i1i1g 1g1c 0g3g"},
    Glyph{'g', 4, "@0c0g4g4c 4g4c ~4c4a1a0b"},
    Glyph{'h', 4, "0i0c ~0e0g4g4e 4e4c"},
    Glyph{'i', 0, "0g0c 0i0i"},
    Glyph{'j', 1, "1g1c ~1c1a0a 1i1i"},
    Glyph{'k', 3, "0i0c 3g0d 1e3c"},
    Glyph{'l', 0, "0i0c"},
    Glyph{'m', 6, "0g0c ~0e0g3g3e 3e3c ~3e3g6g6e 6e6c"},
    Glyph{'n', 4, "0g0c ~0e0g4g4e 4e4c"},
    Glyph{'o', 4, "@0c0g4g4c"},
    Glyph{'p', 4, "0g0a @0c0g4g4c"},
    Glyph{'q', 4, "4g4a @0c0g4g4c"},
    Glyph{'r', 3, "0g0c ~0e0g3g"},
    Glyph{'s', 3, "~3f3g0g0e3e3c0c0d"},
    Glyph{'t', 3, "1i1d ~1d1c3c 0g3g"},
    Glyph{'u', 4, "0g0e ~0e0c4c4e 4g4c"},
    Glyph{'v', 4, "0g2c4g"},
    Glyph{'w', 6, "0g1c3g5c6g"},
    Glyph{'x', 3, "0g3c 0c3g"},
    Glyph{'y', 4, "0g2c 4g1a"},
    Glyph{'z', 3, "0g3g0c3c"},
    Glyph{'A', 4, "0c2i4c 1e3e"},
    Glyph{'B', 4, "0c0i ~0i4i4f0f ~0f4f4c0c"},
    Glyph{'C', 4, "~4h4i0i0c4c4d"},
    Glyph{'D', 4, "0c0i ~0i4i4c0c"},
    Glyph{'E', 4, "4i0i0c4c 0f3f"},
    Glyph{'F', 4, "4i0i0c 0f3f"},
    Glyph{'G', 4, "~4h4i0i0c4c4f 4f2f"},
    Glyph{'H', 4, "0i0c 4i4c 0f4f"},
    Glyph{'I', 2, "0i2i 1i1c 0c2c"},
    Glyph{'J', 3, "3i3e ~3e3c0c0d"},
    Glyph{'K', 4, "0i0c 4i0e 1f4c"},
    Glyph{'L', 3, "0i0c3c"},
    Glyph{'M', 5, "0c0i2d5i5c"},
    Glyph{'N', 4, "0c0i4c4i"},
    Glyph{'O', 5, "@0c0i5i5c"},
    Glyph{'P', 4, "0c0i ~0i4i4f0f"},
    Glyph{'Q', 5, "@0c0i5i5c 3d5b"},
    Glyph{'R', 4, "0c0i ~0i4i4f0f 2f4c"},
    Glyph{'S', 4, "~4h4i0i0f4f4c0c0d"},
    Glyph{'T', 4, "0i4i 2i2c"},
    Glyph{'U', 4, "0i0e ~0e0c4c4e 4e4i"},
    Glyph{'V', 4, "0i2c4i"},
    Glyph{'W', 6, "0i1c3i5c6i"},
    Glyph{'X', 4, "0i4c 0c4i"},
    Glyph{'Y', 4, "0i2f4i 2f2c"},
    Glyph{'Z', 4, "0i4i0c4c"},
    Glyph{' ', 1, ""},
    Glyph{'.', 0, "0c0c"},
    Glyph{',', 1, "1c0b"},
    Glyph{':', 0, "0c0c 0g0g"},
    Glyph{';', 1, "1c0b 1g1g"},
    Glyph{'-', 3, "0f3f"},
    Glyph{'+', 4, "0f4f 2d2h"},
    Glyph{'=', 4, "0e4e 0g4g"},
    Glyph{'/', 3, "0b3i"},
    Glyph{'\\', 3, "0i3b"},
    Glyph{'(', 1, "~1i0h0b1a"},
    Glyph{')', 1, "~0i1h1b0a"},
    Glyph{'[', 1, "1i0i0a1a"},
    Glyph{']', 1, "0i1i1a0a"},
    Glyph{'{', 2, "~2i1i1e0e ~0e1e1a2a"},
    Glyph{'}', 2, "~0i1i1e2e ~2e1e1a0a"},
    Glyph{'<', 3, "3h0f3d"},
    Glyph{'>', 3, "0h3f0d"},
    Glyph{'|', 0, "0i0a"},
    Glyph{'_', 4, "0b4b"},
    Glyph{'*', 2, "1i1f 0h2g 2h0g"},
    Glyph{'\'', 0, "0i0h"},
    Glyph{'"', 1, "0i0h 1i1h"},
    Glyph{'!', 0, "0i0e 0c0c"},
    Glyph{'?', 3, "~0h0i3i3g1g1e 1c1c"},
    Glyph{'#', 4, "1c1i 3c3i 0e4e 0g4g"},
    Glyph{'%', 4, "4i0c 0i0h 4d4c"},
    Glyph{'&', 4, "~4c0i2j3i1f0e0c3c4e"},
    Glyph{'~', 4, "~0f1h3d4f"},
    Glyph{'@', 5, "@1d1g4g4d ~4g4d5d5i0i0c4c"},
    Glyph{'$', 4, "~4h4i0i0f4f4c0c0d 2j2b"},
    Glyph{'`', 1, "0j1h"},
};
constexpr Glyph unknown{'\0', 4, "0c0i4i4c0c"};
constexpr float cap = 6, gap = 1.9f, pen = 0.46f;  // units of the points: height of a capital, space between letters, radius of the pen
constexpr float raised = 0.62f;                    // size of an exponent

const Glyph& glyph(char name) {
    const auto found = std::find_if(glyphs.begin(), glyphs.end(), [&](const Glyph& g) { return g.name == name; });
    return found == glyphs.end() ? unknown : *found;
}

using Point = Eigen::Vector2f;
using Line = std::pair<Point, Point>;

/// The pieces of a quadratic B-spline: each goes from the middle of one side of the polygon to that of the next, bent by the corner
/// between.
void bend(const std::vector<Point>& corner, bool closed, std::vector<Line>& lines) {
    const std::size_t n = corner.size(), pieces = closed ? n : n - 2;
    for (std::size_t k = 0; k < pieces; ++k) {
        const Point &a = corner[k], &b = corner[(k + 1) % n], &c = corner[(k + 2) % n];
        const Point from = !closed && k == 0 ? a : Point(0.5f * (a + b)), to = !closed && k + 1 == pieces ? c : Point(0.5f * (b + c));
        constexpr int steps = 8;
        Point last = from;
        for (int i = 1; i <= steps; ++i) {
            const float t = static_cast<float>(i) / steps;
            const Point next = (1 - t) * (1 - t) * from + 2 * t * (1 - t) * b + t * t * to;
            lines.emplace_back(last, next);
            last = next;
        }
    }
}

void add_strokes(const Glyph& g, const Point& origin, float size, std::vector<Line>& lines) {
    const auto finish = [&](char kind, std::vector<Point>& points) {
        if (kind != '\0') bend(points, kind == '@', lines);
        for (std::size_t k = 0; kind == '\0' && k + 1 < points.size(); ++k) lines.emplace_back(points[k], points[k + 1]);
        points.clear();
    };
    std::vector<Point> points;
    char kind = '\0';
    for (const char* s = g.strokes; *s != '\0'; ++s) {
        if (*s == ' ') {
            finish(kind, points);
            kind = '\0';
        } else if (points.empty() && (*s == '~' || *s == '@')) {
            kind = *s;
        } else {
            const auto x = static_cast<float>(*s - '0'), y = static_cast<float>(*++s - 'c');
            points.push_back(origin + size * Point(x, -y));
        }
    }
    finish(kind, points);
}

/// Calls f(glyph, x, lift, scale) for every letter, x and lift in units; returns the width.
template <class F>
float lay_out(const std::string& text, F&& f) {
    float x = 0;
    bool up = false;
    for (std::size_t n = 0; n < text.size(); ++n) {
        const char c = text[n];
        if (c == '^' && n + 1 < text.size()) {
            up = true;
            continue;
        }
        if (up && !(std::isdigit(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '+' || c == '.')) up = false;
        const float scale = up ? raised : 1.0f;
        const Glyph& g = glyph(c);
        f(g, x, up ? 0.5f * cap : 0.0f, scale);
        x += scale * (g.width + gap);
    }
    return std::max(0.0f, x - gap);
}

float distance(const Point& p, const Line& line) {
    const Point along = line.second - line.first, to = p - line.first;
    const float t = std::clamp(to.dot(along) / std::max(along.squaredNorm(), 1e-12f), 0.0f, 1.0f);
    return (to - t * along).norm();
}

void mix(std::uint8_t* pixel, const Vec3f& colour, float share) {
    for (int c = 0; c < 3; ++c) {
        const float there = linear_light(pixel[c]), wanted = linear_light(static_cast<std::uint8_t>(std::lround(255 * colour[c])));
        pixel[c] = srgb_byte(there + share * (wanted - there));
    }
}

/// @param radius of the pen [pixels] @param soft width of its edge [pixels]
void stroke(Image& image, const std::vector<Line>& lines, float radius, float soft, const Vec3f& colour, float strength) {
    if (lines.empty()) return;
    Point low = lines[0].first, high = low;
    for (const Line& line : lines)
        low = low.cwiseMin(line.first).cwiseMin(line.second), high = high.cwiseMax(line.first).cwiseMax(line.second);
    const float reach = 1.5f * radius + soft;
    const int x0 = std::max(0, static_cast<int>(low.x() - reach)), x1 = std::min(image.width - 1, static_cast<int>(high.x() + reach) + 1);
    const int y0 = std::max(0, static_cast<int>(low.y() - reach)), y1 = std::min(image.height - 1, static_cast<int>(high.y() + reach) + 1);
    for (int y = y0; y <= y1; ++y)
        for (int x = x0; x <= x1; ++x) {
            const Point p(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
            float nearest = reach;
            // A dot is thicker than a stroke, or it would be lost in small print.
            for (const Line& line : lines) nearest = std::min(nearest, distance(p, line) - (line.first == line.second ? 0.5f * radius : 0));
            const float share = strength * std::clamp((radius - nearest) / soft + 0.5f, 0.0f, 1.0f);
            if (share > 0) mix(image.pixel(x, y), colour, share);
        }
}

}  // namespace

float draw_text(Image& image, float x, float y, const std::string& text, const TextStyle& style) {
    const float unit = style.height / cap, radius = std::max(pen * unit, 0.6f);
    std::vector<std::vector<Line>> letters;
    const float width = lay_out(text, [&](const Glyph& g, float at, float lift, float scale) {
        add_strokes(g, Point(x + unit * at, y - unit * lift), unit * scale, letters.emplace_back());
    });
    // All halos first: none may lie over a neighbour's strokes.
    if (style.halo_strength > 0)
        for (const auto& lines : letters) stroke(image, lines, 2.2f * radius, 2 * radius, style.halo, style.halo_strength);
    for (const auto& lines : letters) stroke(image, lines, radius, 1, style.colour, 1);
    return x + unit * (width + gap);
}

float text_width(const std::string& text, float height) {
    return height / cap * lay_out(text, [](const Glyph&, float, float, float) {});
}

void tint_box(Image& image, int x, int y, int width, int height, const Vec3f& colour, float share) {
    for (int row = std::max(0, y); row < std::min(image.height, y + height); ++row)
        for (int column = std::max(0, x); column < std::min(image.width, x + width); ++column) mix(image.pixel(column, row), colour, share);
}

}  // namespace whorl
