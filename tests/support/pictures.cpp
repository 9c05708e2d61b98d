#include "tests/support/pictures.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/core/parallel.h"

namespace whorl {
namespace {

// The mean light of the 3x3 pixels about (x, y); pixels outside repeat the edge.
Vec3f blurred(const Image& image, int x, int y) {
    Vec3f sum = Vec3f::Zero();
    for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
            const std::uint8_t* p = image.pixel(std::clamp(x + dx, 0, image.width - 1), std::clamp(y + dy, 0, image.height - 1));
            sum += Vec3f(linear_light(p[0]), linear_light(p[1]), linear_light(p[2]));
        }
    return sum / 9;
}

// CIE 1976 L*a*b* of linear sRGB under D65.
Vec3f lab(const Vec3f& rgb) {
    static const Mat3f to_xyz =
        (Mat3f() << 0.4124564f, 0.3575761f, 0.1804375f, 0.2126729f, 0.7151522f, 0.0721750f, 0.0193339f, 0.1191920f, 0.9503041f).finished();
    static const Vec3f white = to_xyz * Vec3f::Ones();
    const auto f = [](float t) { return t > 216.0f / 24389 ? std::cbrt(t) : (24389.0f / 27 * t + 16) / 116; };
    const Vec3f xyz = to_xyz * rgb;
    const Vec3f g(f(xyz.x() / white.x()), f(xyz.y() / white.y()), f(xyz.z() / white.z()));
    return {116 * g.y() - 16, 500 * (g.x() - g.y()), 200 * (g.y() - g.z())};
}

}  // namespace

PictureDifference difference(const Image& a, const Image& b) {
    if (a.width != b.width || a.height != b.height) {
        const double infinite = std::numeric_limits<double>::infinity();
        return {infinite, infinite, infinite};
    }
    const Index pixels = a.width * a.height;
    if (pixels == 0) return {};
    std::vector<float> delta(pixels);
    parallel_for(pixels, [&](Index i) {
        const int x = i % a.width, y = i / a.width;
        delta[i] = (lab(blurred(a, x, y)) - lab(blurred(b, x, y))).norm();
    });
    PictureDifference result;
    result.mean = parallel_sum(pixels, [&](Index i) { return delta[i]; }) / pixels;
    std::sort(delta.begin(), delta.end());
    result.p99 = delta[0.99 * (pixels - 1)];
    result.max = delta.back();
    return result;
}

}  // namespace whorl

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
