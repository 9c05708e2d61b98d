#include "render/flow/streaks.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "engine/core/grid_index.h"
#include "engine/core/parallel.h"

namespace whorl {
namespace {

constexpr int half_pieces = 20;        ///< of a streak to each side
constexpr float longest_piece = 1.7f;  ///< pixels; a faster flow has shorter streaks
constexpr float calm = 3;              ///< pixels; flow that moves less has fainter streaks

/// White noise of mean 0 and variance 1 that stands still, for fluid whose particles cannot be told apart.
std::vector<float> still_noise(int width, int height) {
    std::vector<float> noise(grid_count(width, height));
    for (std::size_t k = 0; k < noise.size(); ++k) {
        std::uint32_t h = static_cast<std::uint32_t>(k) * 0x9E3779B1u;
        h ^= h >> 15, h *= 0x2C1B3C6Du, h ^= h >> 12, h *= 0x297A2D39u, h ^= h >> 15;
        noise[k] = 3.4641016f * (static_cast<float>(h >> 8) * (1.0f / 16777216.0f) - 0.5f);
    }
    return noise;
}

/// Linear between the middles of the pixels, constant beyond the outermost.
struct Pixels {
    int width, height;
    struct Place {
        std::size_t corner;
        int right, up;
        float s, t;
    };
    Place place(float x, float y) const {
        x = std::clamp(x, 0.0f, static_cast<float>(width - 1)), y = std::clamp(y, 0.0f, static_cast<float>(height - 1));
        const int i = static_cast<int>(x), j = static_cast<int>(y);
        return {grid_index(i, j, width), i + 1 < width ? 1 : 0, j + 1 < height ? width : 0, x - static_cast<float>(i),
                y - static_cast<float>(j)};
    }
    static float mix(const std::vector<float>& v, const Place& p) {
        const float* a = v.data() + p.corner;
        const float low = a[0] + p.s * (a[p.right] - a[0]), high = a[p.up] + p.s * (a[p.up + p.right] - a[p.up]);
        return low + p.t * (high - low);
    }
};

}  // namespace

std::vector<float> streaks(const PlaneField& field, float seconds, float pixel) {
    const std::vector<float> own = field.noise.empty() ? still_noise(field.width, field.height) : std::vector<float>();
    const std::vector<float>& noise = own.empty() ? field.noise : own;
    const float grain = std::max(1.0f, field.grain_size);
    const Pixels pixels{field.width, field.height};
    const float step = seconds / (half_pieces * pixel);  // s/pixel: velocity -> pixels of one piece
    const auto way = [&](float x, float y) {
        const Pixels::Place p = pixels.place(x, y);
        Eigen::Vector2f v(step * Pixels::mix(field.velocity[0], p), step * Pixels::mix(field.velocity[1], p));
        const float length = v.norm();
        if (length > longest_piece) v *= longest_piece / length;
        return v;
    };
    std::vector<float> brightness(noise.size(), 0.0f);
    parallel_blocks(field.height, 4, [&](Index begin, Index end) {
        for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y)
            for (int x = 0; x < field.width; ++x) {
                const std::size_t k = grid_index(x, y, field.width);
                if (field.cover[k] <= 0) continue;
                float sum = noise[k], weights = 1, length = 0;
                for (const float side : {1.0f, -1.0f}) {
                    float px = static_cast<float>(x), py = static_cast<float>(y);
                    Eigen::Vector2f before = side * way(px, py);
                    for (int s = 1; s <= half_pieces; ++s) {
                        // Adams and Bashforth's second order: one look at the flow a piece
                        const Eigen::Vector2f now = side * way(px, py), v = 1.5f * now - 0.5f * before;
                        before = now;
                        px += v.x(), py += v.y();
                        // A window without ends that one could see flicker (Hann's).
                        const float w = 0.5f + 0.5f * std::cos(3.1415927f * static_cast<float>(s) / (half_pieces + 1));
                        sum += w * Pixels::mix(noise, pixels.place(px, py)), weights += w;
                        length += v.norm();
                    }
                }
                // A mean over half the length counts so many grains.
                const float grains = 1 + length / (2.5f * grain), faint = std::min(1.0f, length / calm);
                brightness[k] = faint * std::sqrt(grains) * sum / weights;
            }
    });
    return brightness;
}

}  // namespace whorl
