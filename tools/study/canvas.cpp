#include "tools/study/canvas.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "render/image/text.h"

namespace whorl {
namespace {

std::string hex(const Vec3f& c) {
    const auto byte = [](float v) { return static_cast<int>(std::lround(255 * std::clamp(v, 0.0f, 1.0f))); };
    return fmt::format("#{:02x}{:02x}{:02x}", byte(c[0]), byte(c[1]), byte(c[2]));
}

std::string escaped(const std::string& text) {
    std::string safe;
    for (const char c : text) safe += c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : std::string(1, c);
    return safe;
}

/// Mixes a pixel towards a colour by how much of it is covered.
void blend(Image& image, int x, int y, const Vec3f& colour, double covered) {
    if (x < 0 || y < 0 || x >= image.width || y >= image.height || covered <= 0) return;
    std::uint8_t* p = image.pixel(x, y);
    const double part = std::min(1.0, covered);
    for (int c = 0; c < 3; ++c) p[c] = static_cast<std::uint8_t>(std::lround(p[c] + part * (255 * colour[c] - p[c])));
}

/// Everything within `radius` of the segment, with an edge one pixel soft.
void thick(Image& image, double x0, double y0, double x1, double y1, double radius, const Vec3f& colour) {
    const double dx = x1 - x0, dy = y1 - y0, length2 = dx * dx + dy * dy;
    const int left = static_cast<int>(std::floor(std::min(x0, x1) - radius - 1)),
              right = static_cast<int>(std::ceil(std::max(x0, x1) + radius + 1));
    const int top = static_cast<int>(std::floor(std::min(y0, y1) - radius - 1)),
              low = static_cast<int>(std::ceil(std::max(y0, y1) + radius + 1));
    for (int y = std::max(0, top); y <= std::min(image.height - 1, low); ++y)
        for (int x = std::max(0, left); x <= std::min(image.width - 1, right); ++x) {
            const double px = x + 0.5 - x0, py = y + 0.5 - y0;
            const double along = length2 > 0 ? std::clamp((px * dx + py * dy) / length2, 0.0, 1.0) : 0;
            blend(image, x, y, colour, radius + 0.5 - std::hypot(px - along * dx, py - along * dy));
        }
}

}  // namespace

Canvas::Canvas(int width, int height) : width_(width), height_(height) {}

void Canvas::line(double x0, double y0, double x1, double y1, const Vec3f& colour, double width) {
    items_.push_back({Kind::line, x0, y0, x1, y1, width, colour, "", 0});
}
void Canvas::disc(double x, double y, double radius, const Vec3f& colour) {
    items_.push_back({Kind::disc, x, y, radius, 0, 0, colour, "", 0});
}
void Canvas::box(double x, double y, double width, double height, const Vec3f& colour) {
    items_.push_back({Kind::box, x, y, width, height, 0, colour, "", 0});
}
void Canvas::words(double x, double y, const std::string& text, const Vec3f& colour, double size, int anchor) {
    items_.push_back({Kind::words, x, y, size, 0, 0, colour, text, anchor});
}

Image Canvas::image() const {
    Image image{width_, height_, std::vector<std::uint8_t>(3 * static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), 255)};
    for (const Item& i : items_) switch (i.kind) {
            case Kind::line: thick(image, i.a, i.b, i.c, i.d, 0.5 * i.width, i.colour); break;
            case Kind::disc: thick(image, i.a, i.b, i.a, i.b, i.c, i.colour); break;
            case Kind::box:
                for (int y = static_cast<int>(std::lround(i.b)); y < std::lround(i.b + i.d); ++y)
                    for (int x = static_cast<int>(std::lround(i.a)); x < std::lround(i.a + i.c); ++x) blend(image, x, y, i.colour, 1);
                break;
            case Kind::words: {
                TextStyle style;
                style.height = static_cast<float>(0.72 * i.c);
                style.colour = i.colour;
                style.halo_strength = 0;
                const double width = text_width(i.text, style.height);
                draw_text(image, static_cast<float>(i.a - 0.5 * (i.anchor + 1) * width), static_cast<float>(i.b), i.text, style);
                break;
            }
        }
    return image;
}

std::string Canvas::svg() const {
    std::string out = fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\">\n<rect width=\"{0}\" "
        "height=\"{1}\" fill=\"#ffffff\"/>\n",
        width_, height_);
    for (const Item& i : items_) switch (i.kind) {
            case Kind::line:
                out +=
                    fmt::format("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"{}\" stroke-width=\"{:.1f}\"/>\n",
                                i.a, i.b, i.c, i.d, hex(i.colour), i.width);
                break;
            case Kind::disc:
                out += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:.1f}\" fill=\"{}\"/>\n", i.a, i.b, i.c, hex(i.colour));
                break;
            case Kind::box:
                out += fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"{}\"/>\n", i.a, i.b, i.c, i.d,
                                   hex(i.colour));
                break;
            case Kind::words:
                out += fmt::format(
                    "<text x=\"{:.1f}\" y=\"{:.1f}\" font-family=\"sans-serif\" font-size=\"{:.1f}\" fill=\"{}\" "
                    "text-anchor=\"{}\">{}</text>\n",
                    i.a, i.b, i.c, hex(i.colour),
                    i.anchor < 0   ? "start"
                    : i.anchor > 0 ? "end"
                                   : "middle",
                    escaped(i.text));
                break;
        }
    return out + "</svg>\n";
}

}  // namespace whorl
