// Iso-lines, relief and arrows of fields with known lines, slopes and paths.
#include "render/flow/marks.h"

#include <catch2/catch.hpp>

#include "engine/core/grid_index.h"

using namespace whorl;

namespace marks_test {

namespace {

constexpr int width = 200, height = 100;

/// Full of fluid, at rest; its value goes from 0 at the left to 1 at the right.
PlaneField ramp() {
    PlaneField field;
    field.width = width, field.height = height;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) field.value[0].push_back(static_cast<float>(x) / width);
    field.cover.assign(field.value[0].size(), 1.0f);
    for (auto& component : field.velocity) component.assign(field.value[0].size(), 0.0f);
    return field;
}

}  // namespace

TEST_CASE("iso-lines divide the range evenly and are one pixel wide") {
    const PlaneField field = ramp();
    const std::vector<float> line = iso_lines(field, field.value[0], {0, 1}, 3);
    for (int x = 0; x < width; ++x) {
        float nearest = 1e9f;
        for (const int at : {50, 100, 150}) nearest = std::min(nearest, std::abs(static_cast<float>(x - at)));
        INFO(x);
        // Half a pixel to each side of its position, and half a pixel of fading.
        CHECK(line[grid_index(x, 50, width)] == Approx(nearest < 0.5f ? 1.0f : 0.0f).margin(1e-3));
    }
}

TEST_CASE("a constant value has no iso-lines and no relief, and a slope facing the lamp is brighter") {
    PlaneField field = ramp();
    const std::vector<float> falling = relief(field, field.value[0], {0, 1}, 1);
    for (float& v : field.value[0]) v = 1 - v;
    const std::vector<float> rising = relief(field, field.value[0], {0, 1}, 1);
    const std::size_t middle = grid_index(100, 50, width);
    CHECK(relief(field, field.value[0], {1, 0}, 1) == rising);  // a descending range does not invert the relief
    CHECK(falling[middle] > 1);                                 // it rises to the right, so its slope faces the lamp on the left
    CHECK(rising[middle] < 1);
    std::fill(field.value[0].begin(), field.value[0].end(), 0.5f);
    for (const float line : iso_lines(field, field.value[0], {0, 1}, 3)) CHECK(line == 0);
    for (const float light : relief(field, field.value[0], {0, 1}, 1)) CHECK(light == Approx(1));
}

TEST_CASE("arrows point along the local flow, have the length of its path, and are missing at rest") {
    PlaneField field = ramp();
    for (const float share : arrows(field, 4, 1, 0.01f).body) CHECK(share == 0);
    field.velocity[0].assign(field.cover.size(), 0.1f);  // m/s; 10 pixels a second
    const Arrows drawn = arrows(field, 4, 1, 0.01f);     // every 50 pixels, 10 to each side
    const auto at = [&](int x, int y) { return drawn.body[grid_index(x, y, width)]; };
    CHECK(at(25, 25) == 1);
    CHECK(at(17, 25) > 0.9f);
    CHECK(at(33, 25) > 0.5f);
    CHECK(at(12, 25) == 0);
    CHECK(at(38, 25) == 0);
    CHECK(at(25, 35) == 0);
    // No longer than the distance to the next arrow.
    const Arrows fast = arrows(field, 4, 100, 0.01f);
    CHECK(fast.body[grid_index(50, 25, width)] == 0);
}

TEST_CASE("streaks of noise without grain have mean 0 and variance 1, and are missing at rest") {
    PlaneField field = ramp();
    field.grain_size = 0;
    for (const float v : streaks(field, 1, 0.01f)) CHECK(v == 0);
    field.velocity[0].assign(field.cover.size(), 0.1f);  // m/s; 10 pixels to each side
    double sum = 0, square = 0;
    const std::vector<float> streak = streaks(field, 1, 0.01f);
    for (const float v : streak) sum += static_cast<double>(v), square += static_cast<double>(v) * static_cast<double>(v);
    const auto pixels = static_cast<double>(streak.size());
    CHECK(sum / pixels == Approx(0).margin(0.1));
    CHECK(square / pixels == Approx(1).margin(0.3));  // 0.73 measured
}

}  // namespace marks_test
