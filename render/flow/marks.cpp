#include "render/flow/marks.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "engine/core/grid_index.h"
#include "engine/core/parallel.h"

namespace whorl {
namespace {

using Point = Eigen::Vector2f;

int longer_side(const PlaneField& field) { return std::max(field.width, field.height); }

/// Slope of the value over the width of the range [1/pixel], from neighbours with fluid. A descending range reverses colours, not slopes.
Point slope_at(const PlaneField& field, const std::vector<float>& value, const std::array<float, 2>& range, int x, int y) {
    const auto difference = [&](int x0, int y0, int x1, int y1) {
        x0 = std::max(x0, 0), y0 = std::max(y0, 0), x1 = std::min(x1, field.width - 1), y1 = std::min(y1, field.height - 1);
        const std::size_t a = grid_index(x0, y0, field.width), b = grid_index(x1, y1, field.width);
        const int apart = x1 - x0 + y1 - y0;
        if (apart == 0 || field.cover[a] <= 0 || field.cover[b] <= 0) return 0.0f;
        return (value[b] - value[a]) / (static_cast<float>(apart) * std::abs(range[1] - range[0]));
    };
    return {difference(x - 1, y, x + 1, y), difference(x, y - 1, x, y + 1)};
}

struct Arrow {
    Point tail, tip;
    float width, head;  ///< pixels, width of the shaft and length of the head
};

/// Distance of a point from the arrow [pixels]; negative inside.
float distance_to(const Arrow& arrow, const Point& x) {
    const float length = (arrow.tip - arrow.tail).norm();
    const Point way = (arrow.tip - arrow.tail) / length, r = x - arrow.tail;
    const float along = r.dot(way), across = std::abs(way.x() * r.y() - way.y() * r.x());
    const float neck = length - arrow.head;
    const float shaft = std::max({-along, along - neck, across - 0.5f * arrow.width});
    constexpr float half_angle = 0.42f;  // radians
    const float side = (across - (length - along) * std::tan(half_angle)) * std::cos(half_angle);
    return std::min(shaft, std::max(side, neck - along));
}

void draw(const Arrow& arrow, float rim, const PlaneField& field, Arrows& onto) {
    const float reach = arrow.head + rim + 2;
    const Point low = arrow.tail.cwiseMin(arrow.tip) - Point::Constant(reach),
                high = arrow.tail.cwiseMax(arrow.tip) + Point::Constant(reach);
    for (int y = std::max(0, static_cast<int>(low.y())); y < std::min<float>(high.y(), static_cast<float>(field.height)); ++y)
        for (int x = std::max(0, static_cast<int>(low.x())); x < std::min<float>(high.x(), static_cast<float>(field.width)); ++x) {
            const float d = distance_to(arrow, Point(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f));
            const std::size_t k = grid_index(x, y, field.width);
            onto.body[k] = std::max(onto.body[k], std::clamp(0.5f - d, 0.0f, 1.0f));
            onto.halo[k] = std::max(onto.halo[k], std::clamp(0.5f + rim - d, 0.0f, 1.0f));
        }
}

}  // namespace

std::vector<float> iso_lines(const PlaneField& field, const std::vector<float>& value, const std::array<float, 2>& range, int count) {
    const float half_width = 0.5f * std::max(1.0f, static_cast<float>(longer_side(field)) / 900);
    constexpr float even = 0.004f;  // slope [line spacings per pixel] below which lines fade, or they would be blotches
    std::vector<float> share(field.cover.size(), 0.0f);
    parallel_for(field.height, [&](Index row) {
        for (int x = 0; x < field.width; ++x) {
            const std::size_t k = grid_index(x, static_cast<int>(row), field.width);
            if (field.cover[k] <= 0) continue;
            const float step = static_cast<float>(count + 1);
            const float level = (value[k] - range[0]) / (range[1] - range[0]) * step;
            const float line = std::clamp(std::round(level), 1.0f, static_cast<float>(count));
            const float slope = step * slope_at(field, value, range, x, static_cast<int>(row)).norm();
            if (slope <= 0) continue;
            share[k] = std::clamp(half_width + 0.5f - std::abs(level - line) / slope, 0.0f, 1.0f) * std::min(1.0f, slope / even);
        }
    });
    return share;
}

std::vector<float> relief(const PlaneField& field, const std::vector<float>& value, const std::array<float, 2>& range, float strength) {
    const Vec3f lamp = Vec3f(-0.5f, 0.5f, 0.7f).normalized();
    const float high = strength * 0.1f * static_cast<float>(longer_side(field));
    std::vector<float> light(field.cover.size(), 1.0f);
    parallel_for(field.height, [&](Index row) {
        for (int x = 0; x < field.width; ++x) {
            const std::size_t k = grid_index(x, static_cast<int>(row), field.width);
            if (field.cover[k] <= 0) continue;
            const Point slope = high * slope_at(field, value, range, x, static_cast<int>(row));
            const float facing = Vec3f(-slope.x(), -slope.y(), 1).normalized().dot(lamp) / lamp.z();
            light[k] = 0.35f + 0.65f * std::max(0.0f, facing);
        }
    });
    return light;
}

Arrows arrows(const PlaneField& field, int count, float seconds, float pixel) {
    const float apart = static_cast<float>(longer_side(field)) / static_cast<float>(count);
    const float thick = std::max(1.0f, apart / 26), rim = 0.6f * thick;
    Arrows result{std::vector<float>(field.cover.size(), 0.0f), std::vector<float>(field.cover.size(), 0.0f)};
    for (float y = 0.5f * apart; y < static_cast<float>(field.height); y += apart)
        for (float x = 0.5f * apart; x < static_cast<float>(field.width); x += apart) {
            const std::size_t k = grid_index(static_cast<int>(x), static_cast<int>(y), field.width);
            if (field.cover[k] < 0.4f) continue;
            Point half = Point(field.velocity[0][k], field.velocity[1][k]) * (seconds / pixel);
            half *= std::min(1.0f, arrow_reach * apart / std::max(half.norm(), 1e-6f));
            if (2 * half.norm() < 2.5f * thick) continue;
            draw({Point(x, y) - half, Point(x, y) + half, thick, std::min(6 * thick, 1.2f * half.norm())}, rim, field, result);
        }
    return result;
}

namespace {

constexpr int half_pieces = 20;        ///< number of integration steps to each side of a pixel
constexpr float longest_piece = 1.7f;  ///< pixels, longest step; limits the streaks of fast flow
constexpr float calm = 3;              ///< pixels; shorter streaks are fainter

/// Static white noise of mean 0 and variance 1, for frames without "grain".
std::vector<float> still_noise(int width, int height) {
    std::vector<float> noise(grid_count(width, height));
    for (std::size_t k = 0; k < noise.size(); ++k) {
        std::uint32_t h = static_cast<std::uint32_t>(k) * 0x9E3779B1u;
        h ^= h >> 15, h *= 0x2C1B3C6Du, h ^= h >> 12, h *= 0x297A2D39u, h ^= h >> 15;
        noise[k] = 3.4641016f * (static_cast<float>(h >> 8) * (1.0f / 16777216.0f) - 0.5f);
    }
    return noise;
}

/// Linear interpolation between pixel centres, constant beyond the outermost.
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
    const float step = seconds / (half_pieces * pixel);  // s pixel/m, velocity [m/s] -> displacement of one step [pixels]
    const auto displacement = [&](float x, float y) {
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
                    Eigen::Vector2f before = side * displacement(px, py);
                    for (int s = 1; s <= half_pieces; ++s) {
                        // Adams-Bashforth, second order: one velocity sample per step
                        const Eigen::Vector2f now = side * displacement(px, py), v = 1.5f * now - 0.5f * before;
                        before = now;
                        px += v.x(), py += v.y();
                        // A Hann window, which has no visible ends that could flicker.
                        const float w = 0.5f + 0.5f * std::cos(3.1415927f * static_cast<float>(s) / (half_pieces + 1));
                        sum += w * Pixels::mix(noise, pixels.place(px, py)), weights += w;
                        length += v.norm();
                    }
                }
                // Number of grains in the mean, whose effective width is half the length.
                const float grains = 1 + length / (2.5f * grain), faint = std::min(1.0f, length / calm);
                brightness[k] = faint * std::sqrt(grains) * sum / weights;
            }
    });
    return brightness;
}

}  // namespace whorl
