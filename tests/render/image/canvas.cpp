#include "render/image/canvas.h"

#include <catch2/catch.hpp>

using namespace whorl;

namespace {

Canvas drawing() {
    Canvas canvas(120, 80);
    canvas.box(10, 10, 30, 20, Vec3f(0, 0, 1));
    canvas.line(0, 60, 120, 60, Vec3f(1, 0, 0), 3);
    canvas.disc(90, 20, 8, Vec3f(0, 1, 0));
    canvas.words(60, 50, "a < b", Vec3f::Zero(), 13, 0);
    return canvas;
}

std::array<int, 3> at(const Image& image, int x, int y) {
    const std::uint8_t* p = image.pixel(x, y);
    return {p[0], p[1], p[2]};
}

}  // namespace

TEST_CASE("a canvas draws shapes on white in their colours", "[render]") {
    const Image image = drawing().image();
    CHECK(image.width == 120);
    CHECK(image.height == 80);
    CHECK(at(image, 1, 1) == std::array{255, 255, 255});
    CHECK(at(image, 20, 20) == std::array{0, 0, 255});
    CHECK(at(image, 100, 60) == std::array{255, 0, 0});
    CHECK(at(image, 90, 20) == std::array{0, 255, 0});
    for (const int x : {83, 96})
        for (const int y : {16, 23}) CHECK(at(image, x, y)[0] < 50);  // at the rim of the disc
    int dark = 0;
    for (int x = 30; x < 90; ++x)
        for (int y = 38; y < 55; ++y) dark += image.pixel(x, y)[1] < 100 ? 1 : 0;
    CHECK(dark > 10);
}

TEST_CASE("a canvas writes identical SVG every time", "[render]") {
    const std::string svg = drawing().svg();
    CHECK(svg.find("<svg ") != std::string::npos);
    CHECK(svg.rfind("</svg>") != std::string::npos);
    CHECK(svg == drawing().svg());
    CHECK(svg == drawing().svg());
}
