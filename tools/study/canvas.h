#pragma once
/// Drawings that are written both as SVG and as a picture: lines, discs, boxes, words.
#include <string>
#include <vector>

#include "engine/core/types.h"
#include "render/image/image.h"

namespace whorl {

class Canvas {
public:
    Canvas(int width, int height);
    /// Colours are sRGB, 0 .. 1; positions pixels from the upper left.
    void line(double x0, double y0, double x1, double y1, const Vec3f& colour, double width = 1);
    void disc(double x, double y, double radius, const Vec3f& colour);
    void box(double x, double y, double width, double height, const Vec3f& colour);
    /// @param anchor -1: x is where the words begin, 0: their middle, 1: their end
    void words(double x, double y, const std::string& text, const Vec3f& colour, double size = 13, int anchor = -1);

    Image image() const;
    std::string svg() const;

private:
    enum class Kind { line, disc, box, words };
    struct Item {
        Kind kind;
        double a, b, c, d;  ///< ends; middle and radius; corner and size; place and size
        double width;       ///< of a line
        Vec3f colour;
        std::string text;
        int anchor;
    };
    int width_, height_;
    std::vector<Item> items_;
};

}  // namespace whorl
