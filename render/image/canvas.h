#pragma once
/// Drawings that are written both as SVG and as a picture: lines, discs, boxes, words.
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
    /// Colours are sRGB, 0 .. 1; positions pixels from the upper left.
    void line(double x0, double y0, double x1, double y1, const Vec3f& colour, double width = 1);
    /// Straight from point to point.
    void path(const std::vector<std::array<double, 2>>& points, const Vec3f& colour, double width = 1, bool dashed = false);
    void disc(double x, double y, double radius, const Vec3f& colour);
    void box(double x, double y, double width, double height, const Vec3f& colour);
    /// @param size of the font [pixels] @param anchor -1: x is where the words begin, 0: their middle, 1: their end
    void words(double x, double y, const std::string& text, const Vec3f& colour, double size = 13, int anchor = -1);
    /// Width of words of that size [pixels].
    static double width_of(const std::string& text, double size);

    Image image() const;
    /// Deterministic bytes. The first text is its title, all others its description: letters are drawn as outlines.
    std::string svg() const;

private:
    void draw(cairo_t* to) const;
    int width_, height_;
    std::vector<std::function<void(cairo_t*)>> calls_;
    std::vector<std::string> words_;
};

}  // namespace whorl
