#include "tests/support/pictures.h"

#include <algorithm>
#include <cmath>

namespace whorl::test {

Image flat_picture(int width, int height, std::uint8_t r, std::uint8_t g, std::uint8_t b) {
    Image image{width, height, std::vector<std::uint8_t>(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height))};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) std::copy_n(std::initializer_list<std::uint8_t>{r, g, b}.begin(), 3, image.pixel(x, y));
    return image;
}

Image studio_picture(int width, int height) {
    Image image = flat_picture(width, height, 0, 0, 0);
    std::uint32_t noise = 1;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const double u = static_cast<double>(x) / height, v = static_cast<double>(y) / height;
            double light = 150 + 60 * v - 30 * (u - 0.9) * (u - 0.9), red = 1, blue = 1;
            for (int ball = 0; ball < 5; ++ball) {
                const double dx = u - 0.3 - 0.3 * ball, dy = v - 0.5 - 0.1 * (ball % 2), r = 0.14;
                const double z2 = r * r - dx * dx - dy * dy;
                if (z2 > 0) light = 60 + 140 * std::sqrt(z2) / r + 40 * std::sin(60 * dx) * std::sin(45 * dy), red = 1.1, blue = 0.35;
            }
            noise = noise * 1664525u + 1013904223u;
            light += static_cast<double>(noise >> 24) / 128 - 1;
            const double rgb[3] = {light * red, light * 0.95, light * blue};
            for (int c = 0; c < 3; ++c) image.pixel(x, y)[c] = static_cast<std::uint8_t>(std::clamp(rgb[c], 0.0, 255.0));
        }
    return image;
}

}  // namespace whorl::test
