#include "render/image/canvas.h"

#include <cairo-svg.h>

#include <numbers>

#include "engine/core/errors.h"
#include "render/image/font.h"

namespace whorl {
namespace {

void set_colour(cairo_t* to, const Vec3f& c) { cairo_set_source_rgb(to, c[0], c[1], c[2]); }

std::string as_xml(const std::string& text) {
    std::string out;
    for (const char c : text) out += c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : std::string(1, c);
    return out;
}

cairo_status_t append_text(void* text, const unsigned char* data, unsigned int length) {
    static_cast<std::string*>(text)->append(reinterpret_cast<const char*>(data), length);
    return CAIRO_STATUS_SUCCESS;
}

}  // namespace

Canvas::Canvas(int width, int height) : width_(width), height_(height) { box(0, 0, width, height, Vec3f::Ones()); }

void Canvas::line(double x0, double y0, double x1, double y1, const Vec3f& colour, double width) {
    calls_.emplace_back([=](cairo_t* to) {
        set_colour(to, colour);
        cairo_set_line_width(to, width);
        cairo_move_to(to, x0, y0);
        cairo_line_to(to, x1, y1);
        cairo_stroke(to);
    });
}
void Canvas::path(const std::vector<std::array<double, 2>>& points, const Vec3f& colour, double width, bool dashed) {
    calls_.emplace_back([=](cairo_t* to) {
        const double dash = 3 * width;
        set_colour(to, colour);
        cairo_set_line_width(to, width);
        cairo_set_line_join(to, CAIRO_LINE_JOIN_ROUND);
        if (dashed) cairo_set_dash(to, &dash, 1, 0);
        cairo_new_path(to);  // a text leaves a current point
        for (const auto& p : points) cairo_line_to(to, p[0], p[1]);
        cairo_stroke(to);
        cairo_set_dash(to, nullptr, 0, 0);
    });
}
void Canvas::disc(double x, double y, double radius, const Vec3f& colour) {
    calls_.emplace_back([=](cairo_t* to) {
        set_colour(to, colour);
        cairo_arc(to, x, y, radius, 0, 2 * std::numbers::pi);
        cairo_fill(to);
    });
}
void Canvas::box(double x, double y, double width, double height, const Vec3f& colour) {
    calls_.emplace_back([=](cairo_t* to) {
        set_colour(to, colour);
        cairo_rectangle(to, x, y, width, height);
        cairo_fill(to);
    });
}
void Canvas::words(double x, double y, const std::string& text, const Vec3f& colour, double size, int anchor) {
    words_.push_back(text);
    calls_.emplace_back([=, line = lay_out(text, size)](cairo_t* to) {
        set_colour(to, colour);
        draw_line(to, line, x - 0.5 * (anchor + 1) * line.width, y, cairo_show_text);
    });
}
double Canvas::width_of(const std::string& text, double size) { return lay_out(text, size).width; }

void Canvas::draw(cairo_t* to) const {
    for (const auto& call : calls_) call(to);
    WHORL_ASSERT(cairo_status(to) == CAIRO_STATUS_SUCCESS, +std::string(cairo_status_to_string(cairo_status(to))));
}

Image Canvas::image() const {
    const CairoSurface surface(cairo_image_surface_create(CAIRO_FORMAT_RGB24, width_, height_));
    draw(CairoContext(cairo_create(surface.get())).get());
    cairo_surface_flush(surface.get());
    const unsigned char* data = cairo_image_surface_get_data(surface.get());
    const int stride = cairo_image_surface_get_stride(surface.get());
    Image image = plain_image(width_, height_, 255);
    for (int y = 0; y < height_; ++y)
        for (int x = 0; x < width_; ++x) {
            const unsigned char* p = data + y * stride + 4 * x;  // blue, green, red, unused
            for (int c = 0; c < 3; ++c) image.pixel(x, y)[c] = p[2 - c];
        }
    return image;
}

std::string Canvas::svg() const {
    std::string text;
    {
        const CairoSurface surface(cairo_svg_surface_create_for_stream(append_text, &text, width_, height_));
        cairo_svg_surface_set_document_unit(surface.get(), CAIRO_SVG_UNIT_PX);
        draw(CairoContext(cairo_create(surface.get())).get());
    }
    // Removes the id, which nothing refers to: Cairo numbers it by the surfaces of the whole program, so it is not deterministic.
    if (const std::size_t begin = text.find(" id=\"surface"); begin != std::string::npos)
        text.erase(begin, text.find('"', begin + 5) + 1 - begin);
    if (words_.empty()) return text;
    std::string described = "\n<title>" + as_xml(words_[0]) + "</title>\n<desc>";
    for (std::size_t k = 1; k < words_.size(); ++k) described += as_xml(words_[k]) + "\n";
    text.insert(text.find('>', text.find("<svg ")) + 1, described + "</desc>");
    return text;
}

}  // namespace whorl
