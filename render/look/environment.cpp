#include "render/look/environment.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/core/grid_index.h"
#include "render/image/image.h"

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
    FloatImage picture = read_hdr(file);
    return {picture.width, picture.height, std::move(picture.rgb)};
}

std::array<Vec3f, 9> light_of(const Environment& environment) {
    std::array<Vec3f, 9> sum;
    sum.fill(Vec3f::Zero());
    for (int y = 0; y < environment.height; ++y) {
        const float down = pi * (static_cast<float>(y) + 0.5f) / static_cast<float>(environment.height);
        const float angle = 2 * pi * pi * std::sin(down) / static_cast<float>(environment.width * environment.height);  // solid, of a pixel
        for (int x = 0; x < environment.width; ++x) {
            const std::array<float, 9> t = terms(environment.direction(x, y));
            const Vec3f light = angle * environment.at(x, y);
            for (int k = 0; k < 9; ++k) sum[k] += t[k] * light;
        }
    }
    // Squares of the harmonics' factors, times what a cosine keeps of their order: 1, 2/3, 1/4.
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

}  // namespace whorl
