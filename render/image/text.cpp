#include "render/image/text.h"

#include <algorithm>
#include <cmath>

#include "render/image/font.h"

namespace whorl {
namespace {

void mix(Image& image, int x, int y, const Vec3f& colour, float share) {
    std::uint8_t* pixel = image.pixel(x, y);
    if (!image.alpha.empty()) {  // alpha is straight: the old colour counts in proportion to its alpha
        std::uint8_t& alpha = image.alpha[grid_index(x, y, image.width)];
        const float before = static_cast<float>(alpha) / 255, after = share + before * (1 - share);
        alpha = static_cast<std::uint8_t>(std::lround(255 * after));
        share = after > 0 ? share / after : 0;
    }
    for (int c = 0; c < 3; ++c) {
        const float there = linear_light(pixel[c]), wanted = linear_light(static_cast<std::uint8_t>(std::lround(255 * colour[c])));
        pixel[c] = srgb_byte(there + share * (wanted - there));
    }
}

/// Part of an image, with the fraction of each pixel that a drawing covers.
class Mask {
public:
    /// Pixels left to right and top to bottom, limited to those of the image.
    Mask(const Image& image, float left, float top, float right, float bottom)
        : x_(within(left, image.width)), y_(within(top, image.height)), width_(within(right, image.width) - x_),
          height_(within(bottom, image.height) - y_), surface_(cairo_image_surface_create(CAIRO_FORMAT_A8, width_, height_)) {
        cairo_surface_set_device_offset(surface_.get(), -x_, -y_);
    }
    CairoContext draw() const { return CairoContext(cairo_create(surface_.get())); }
    void mix_into(Image& image, const Vec3f& colour, float strength) const {
        cairo_surface_flush(surface_.get());
        const unsigned char* covered = cairo_image_surface_get_data(surface_.get());
        const int stride = cairo_image_surface_get_stride(surface_.get());
        for (int y = 0; y < height_; ++y)
            for (int x = 0; x < width_; ++x)
                if (const int share = covered[y * stride + x]; share > 0)
                    mix(image, x_ + x, y_ + y, colour, strength * static_cast<float>(share) / 255);
    }

private:
    static int within(float x, int size) { return static_cast<int>(std::clamp(std::floor(x), 0.0f, static_cast<float>(size))); }
    int x_, y_, width_, height_;
    CairoSurface surface_;
};

}  // namespace

void draw_text(Image& image, float x, float y, const std::string& text, const TextStyle& style) {
    const TextLine line = lay_out(text, style.height / capital_height);
    const float end = x + static_cast<float>(line.width), h = style.height;
    const auto mask = [&] { return Mask(image, x - h, y - 2 * h, end + h, y + h); };
    if (style.halo_strength > 0) {
        const Mask halo = mask();
        const CairoContext to = halo.draw();
        draw_line(to.get(), line, x, y, cairo_text_path);
        cairo_set_line_join(to.get(), CAIRO_LINE_JOIN_ROUND);
        cairo_set_line_width(to.get(), 0.25 * h);
        cairo_stroke_preserve(to.get());
        cairo_fill(to.get());
        halo.mix_into(image, style.halo, style.halo_strength);
    }
    const Mask letters = mask();
    draw_line(letters.draw().get(), line, x, y, cairo_show_text);
    letters.mix_into(image, style.colour, 1);
}

float text_width(const std::string& text, float height) { return static_cast<float>(lay_out(text, height / capital_height).width); }

void tint_box(Image& image, int x, int y, int width, int height, const Vec3f& colour, float share) {
    for (int row = std::max(0, y); row < std::min(image.height, y + height); ++row)
        for (int column = std::max(0, x); column < std::min(image.width, x + width); ++column) mix(image, column, row, colour, share);
}

}  // namespace whorl
