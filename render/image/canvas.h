#pragma once
/// Drawings of lines, discs, boxes and text, written as SVG or as an image.
#include <array>
#include <functional>
#include <string>
#include <vector>

#include "engine/core/types.h"
#include "render/image/image.h"

typedef struct _cairo cairo_t;

namespace whorl {

class Canvas {
public:
    Canvas(int width, int height);
    /// Colours are sRGB, 0 .. 1. Positions are in pixels from the upper left.
    void line(double x0, double y0, double x1, double y1, const Vec3f& colour, double width = 1);
    /// Straight lines from point to point.
    void path(const std::vector<std::array<double, 2>>& points, const Vec3f& colour, double width = 1, bool dashed = false);
    void disc(double x, double y, double radius, const Vec3f& colour);
    void box(double x, double y, double width, double height, const Vec3f& colour);
    /// Text with its baseline at y. @param size font size [pixels] @param anchor -1: the text starts at x, 0: is centred at x, 1: ends at x
    void words(double x, double y, const std::string& text, const Vec3f& colour, double size = 13, int anchor = -1);
    /// Width of the text at this font size [pixels].
    static double width_of(const std::string& text, double size);

    Image image() const;
    /// The drawing as an SVG file with deterministic bytes. Letters are outlines, so the first text is also stored as the title, and the
    /// others as the description.
    std::string svg() const;

private:
    void draw(cairo_t* to) const;
    int width_, height_;
    std::vector<std::function<void(cairo_t*)>> calls_;
    std::vector<std::string> words_;
};

}  // namespace whorl
