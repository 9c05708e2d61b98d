#include "render/look/environment.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/core/grid_index.h"
#include "render/image/exr.h"

namespace whorl {
namespace {

constexpr float pi = std::numbers::pi_v<float>;

std::array<float, 9> terms(const Vec3f& n) {
    const float x = n.x(), y = n.y(), z = n.z();
    return {1, y, z, x, x * y, y * z, 3 * z * z - 1, x * z, x * x - y * y};
}

}  // namespace

Vec3f Environment::at(int x, int y) const {
    const float* p = &rgb[3 * grid_index(x, y, width)];
    return {p[0], p[1], p[2]};
}

Vec3f Environment::direction(int x, int y) const {
    const float round = 2 * pi * ((static_cast<float>(x) + 0.5f) / static_cast<float>(width) - 0.5f);
    const float down = pi * (static_cast<float>(y) + 0.5f) / static_cast<float>(height);
    return {std::sin(down) * std::sin(round), std::cos(down), -std::sin(down) * std::cos(round)};
}

Environment read_environment(const std::filesystem::path& file) {
    const PictureLayers picture = read_exr(file);
    Environment environment{picture.width, picture.height, {}};
    for (std::size_t i = 0; i < picture.light.size(); ++i)
        if (i % 4 < 3) environment.rgb.push_back(std::isfinite(picture.light[i]) ? std::max(picture.light[i], 0.0f) : 0);
    return environment;
}

std::array<Vec3f, 9> light_of(const Environment& environment) {
    std::array<Vec3f, 9> sum;
    sum.fill(Vec3f::Zero());
    for (int y = 0; y < environment.height; ++y) {
        const float down = pi * (static_cast<float>(y) + 0.5f) / static_cast<float>(environment.height);
        const float angle =
            2 * pi * pi * std::sin(down) / static_cast<float>(environment.width * environment.height);  // solid angle of a pixel
        for (int x = 0; x < environment.width; ++x) {
            const std::array<float, 9> t = terms(environment.direction(x, y));
            const Vec3f light = angle * environment.at(x, y);
            for (int k = 0; k < 9; ++k) sum[k] += t[k] * light;
        }
    }
    // Squared normalisation factor of each harmonic, times the factor of a cosine lobe for its order: 1, 2/3, 1/4.
    constexpr float first = 0.079577f, second = 2.0f / 3 * 0.238732f, third = 0.25f;
    const std::array<float, 9> factor{
        first, second, second, second, third * 1.193662f, third * 1.193662f, third * 0.099472f, third * 1.193662f, third * 0.298416f};
    for (int k = 0; k < 9; ++k) sum[k] *= factor[k];
    return sum;
}

Vec3f light_on(const std::array<Vec3f, 9>& light, const Vec3f& normal) {
    const std::array<float, 9> t = terms(normal);
    Vec3f sum = Vec3f::Zero();
    for (int k = 0; k < 9; ++k) sum += t[k] * light[k];
    return sum.cwiseMax(0.0f);
}

Vec3f brightest_side(const std::array<Vec3f, 9>& light) {
    Vec3f side(light[3].sum(), light[1].sum(), light[2].sum());
    const float level = std::hypot(side.x(), side.z());
    if (level < 1e-6f) return Vec3f::UnitY();
    side.y() = std::max(side.y(), 0.7f * level);
    return side.normalized();
}

Studio studio_of(const std::string& background) {
    Studio studio;
    studio.backdrop_low = {0.56f, 0.56f, 0.56f};
    studio.backdrop_high = {0.33f, 0.335f, 0.345f};
    studio.backdrop_glow = {0.40f, 0.39f, 0.38f};
    studio.key = {38.0f, 37.6f, 37.0f};
    studio.window = {5.0f, 4.9f, 4.7f};
    studio.rim = {16.0f, 16.1f, 16.3f};
    studio.fill = {0.5f, 0.5f, 0.5f};
    studio.sky = {0.62f, 0.62f, 0.62f};
    studio.sun = {0.55f, 0.54f, 0.52f};
    if (background == "dark") {
        studio.backdrop_low = {0.030f, 0.032f, 0.037f};
        studio.backdrop_high = {0.012f, 0.013f, 0.016f};
        studio.backdrop_glow = {0.10f, 0.10f, 0.11f};
        studio.sky = {0.30f, 0.30f, 0.32f};
    } else if (background == "white") {
        studio.backdrop_low = {0.95f, 0.95f, 0.95f};
        studio.backdrop_high = {0.90f, 0.90f, 0.90f};
        studio.backdrop_glow = {0.12f, 0.12f, 0.12f};
    }
    return studio;
}

Studio scaled(Studio studio, float factor) {
    for (Vec3f* light : {&studio.backdrop_low, &studio.backdrop_high, &studio.backdrop_glow, &studio.key, &studio.window, &studio.rim,
                         &studio.fill, &studio.sky, &studio.sun})
        *light *= factor;
    return studio;
}

std::vector<std::string> background_names() { return {"studio", "dark", "white", "transparent"}; }

Mat3f studio_axes(const View& view) {
    const Mat3f camera = camera_axes(view);
    const Vec3f right = camera.row(0), above = camera.row(1), back = camera.row(2), up = view.up.normalized();
    Mat3f axes;
    axes.row(0) = right.transpose();
    axes.row(1) = (back.cross(up).norm() < 1e-3f ? above : up).transpose();  // looking straight up or down: the image's up
    axes.row(2) = right.cross(Vec3f(axes.row(1))).transpose();
    return axes;
}

Mat3f turned_back(float degrees) { return Eigen::AngleAxisf(-degrees * pi / 180, Vec3f::UnitY()).toRotationMatrix(); }

Vec3f lamp_of_clouds() { return Vec3f(-0.62f, 0.68f, 0.38f).normalized(); }

Vec3f shadow_light() { return Vec3f(-0.50f, 0.80f, -0.42f).normalized(); }

}  // namespace whorl
