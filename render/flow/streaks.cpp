#include "render/flow/streaks.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "engine/core/grid_index.h"
#include "engine/core/parallel.h"

namespace whorl {
namespace {

/// White noise, 0 .. 1, of a pixel.
float noise(int x, int y) {
    std::uint32_t h = static_cast<std::uint32_t>(x) * 0x9E3779B1u ^ static_cast<std::uint32_t>(y) * 0x85EBCA77u;
    h ^= h >> 15, h *= 0x2C1B3C6Du, h ^= h >> 12, h *= 0x297A2D39u, h ^= h >> 15;
    return static_cast<float>(h >> 8) * (1.0f / 16777216.0f);
}

}  // namespace

std::vector<float> streaks(const std::vector<Eigen::Vector2f>& velocity, int nx, int ny, int half_length) {
    std::vector<float> brightness(velocity.size(), 0.5f);
    const auto pixel = [&](float x, float y) -> const Eigen::Vector2f* {
        const int i = static_cast<int>(std::lround(x)), j = static_cast<int>(std::lround(y));
        if (i < 0 || j < 0 || i >= nx || j >= ny) return nullptr;
        return &velocity[grid_index(i, j, nx)];
    };
    const float contrast = std::sqrt(2.0f * static_cast<float>(half_length) + 1);  // of a mean of so many independent pixels
    parallel_blocks(ny, 4, [&](Index begin, Index end) {
        for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y)
            for (int x = 0; x < nx; ++x) {
                float sum = noise(x, y);
                int count = 1;
                for (const float way : {1.0f, -1.0f}) {
                    float px = static_cast<float>(x), py = static_cast<float>(y);
                    for (int s = 0; s < half_length; ++s) {
                        const Eigen::Vector2f* v = pixel(px, py);
                        const float speed = v == nullptr ? 0.0f : v->norm();
                        if (!(speed > 0)) break;
                        px += way * v->x() / speed, py += way * v->y() / speed;
                        sum += noise(static_cast<int>(std::lround(px)), static_cast<int>(std::lround(py)));
                        ++count;
                    }
                }
                const float mean = sum / static_cast<float>(count);
                brightness[grid_index(x, y, nx)] = std::clamp(0.5f + 0.6f * contrast * (mean - 0.5f), 0.0f, 1.0f);
            }
    });
    return brightness;
}

}  // namespace whorl
