#include "render/flow/vortex_lines.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "tests/support/on_threads.h"

using namespace whorl;

namespace {

struct Vortex {
    Frame frame;
    FlowGrid grid;
};

/// A box of 2 x 2 x 1 m, 20 particles to the metre; the one at `seed` has the lowest grain.
template <class Vorticity, class Strength>
Vortex box(const Vec3f& seed, Vorticity&& vorticity, Strength&& strength, bool periodic = false) {
    Vortex v;
    v.frame.spacing = 0.05f;
    v.frame.domain_min = Vec3f(-1, -1, 0), v.frame.domain_max = Vec3f(1, 1, 1);
    v.frame.periodic = {false, false, periodic};
    std::vector<Eigen::Vector4f> value;
    std::vector<Vec3f> omega;
    const auto add = [&](const Vec3f& x) {
        v.frame.position.push_back(x);
        v.frame.velocity.emplace_back(0, 0, 0);
        v.frame.scalar["grain"].push_back((x - seed).norm() < 1e-3f ? 0.1f : 0.5f);
        omega.push_back(vorticity(x));
        value.push_back(strength(x) * Eigen::Vector4f(1, 0.5f, 0, 1));
    };
    for (int k = 0; k < 20; ++k)
        for (int j = 0; j < 40; ++j)
            for (int i = 0; i < 40; ++i)
                add(Vec3f(-1, -1, 0) +
                    0.05f * Vec3f(static_cast<float>(i) + 0.5f, static_cast<float>(j) + 0.5f, static_cast<float>(k) + 0.5f));
    v.grid = flow_grid(v.frame, omega, value);
    return v;
}

LineShape one_line(float width) {
    LineShape shape;
    shape.seeds = 1, shape.width = width, shape.length = 4;
    return shape;
}

Vec3f round_axis(const Vec3f& x) { return Vec3f(-x.y(), x.x(), 0); }
float everywhere(const Vec3f&) { return 1; }
constexpr int around = 8;

/// Middle of the section whose first corner this is.
Vec3f middle(const VortexLines& lines, std::size_t first) {
    Vec3f sum = Vec3f::Zero();
    for (std::size_t c = 0; c < around; ++c) sum += lines.position[first + c];
    return sum / around;
}

}  // namespace

TEST_CASE("the line of a vortex ring is a closed ring", "[render][flow]") {
    const Vortex v = box(Vec3f(0.625f, 0.025f, 0.525f), round_axis, everywhere);
    const VortexLines lines = vortex_lines(v.frame, v.grid, one_line(0.04f));
    REQUIRE(lines.position.size() > 20 * around);
    // Midpoint steps of half a spacing keep the radius; the grid's means of a linear field are exact.
    for (std::size_t k = 0; k + around <= lines.position.size(); k += around) {
        const Vec3f x = middle(lines, k);
        CHECK(x.head<2>().norm() == Approx(0.6255f).margin(2e-3));
        CHECK(x.z() == Approx(0.525f).margin(1e-4));
        CHECK((lines.position[k] - x).norm() == Approx(0.02f).epsilon(1e-3));
    }
    // One turn: 2 pi .6255 m in steps of 25 mm, the seed again, and two end caps.
    CHECK(static_cast<double>(lines.position.size()) / around == Approx(2 * std::numbers::pi * 0.6255 / 0.025 + 3).margin(1));
    REQUIRE(lines.index.size() % 3 == 0);
    for (std::size_t k = 0; k < lines.index.size(); k += 3) {
        const std::uint32_t a = lines.index[k], b = lines.index[k + 1], c = lines.index[k + 2];
        REQUIRE((a != b && b != c && c != a));
    }
}

TEST_CASE("a tube is thin where the field is weak, and no line starts there", "[render][flow]") {
    const auto up = [](const Vec3f&) { return Vec3f(0, 0, 2); };
    const auto strong_below = [](const Vec3f& x) { return x.z() < 0.5f ? 1.0f : 0.25f; };
    const Vortex v = box(Vec3f(0.025f, 0.025f, 0.325f), up, strong_below, true);
    const VortexLines lines = vortex_lines(v.frame, v.grid, one_line(0.04f));
    float below = 0, above = 0;
    for (const Vec3f& x : lines.position) {
        const float away = (x.head<2>() - Eigen::Vector2f(0.025f, 0.025f)).norm();
        if (x.z() > 0.1f && x.z() < 0.4f) below = std::max(below, away);
        if (x.z() > 0.6f && x.z() < 0.9f) above = std::max(above, away);
        CHECK((x.z() > -0.05f && x.z() < 1.05f));  // a line that leaves a periodic box re-enters on the other side
    }
    CHECK(below == Approx(0.02f).epsilon(0.02));
    CHECK(above == Approx(0.006f).epsilon(0.05));  // 2 (.25 - .1) of it
    const Vortex none = box(Vec3f(0.025f, 0.025f, 0.325f), up, [](const Vec3f&) { return 0.05f; });
    CHECK(vortex_lines(none.frame, none.grid, one_line(0.04f)).position.empty());
}

TEST_CASE("a ribbon twists as the neighbouring lines wind", "[render][flow]") {
    // Lines that wind once in a metre about the axis.
    const float wind = 2 * std::numbers::pi_v<float>;
    const auto winding = [&](const Vec3f& x) { return Vec3f(-wind * (x.y() - 0.025f), wind * (x.x() - 0.025f), 1); };
    const Vortex v = box(Vec3f(0.025f, 0.025f, 0.525f), winding, everywhere);
    LineShape shape = one_line(0.04f);
    shape.flat = true;
    const VortexLines lines = vortex_lines(v.frame, v.grid, shape);
    REQUIRE(lines.position.size() > 20 * around);
    const auto angle_at = [&](float z) {
        std::size_t nearest = 0;
        for (std::size_t k = 0; k + around <= lines.position.size(); k += around)
            if (std::abs(middle(lines, k).z() - z) < std::abs(middle(lines, nearest).z() - z)) nearest = k;
        const Vec3f side = lines.position[nearest] - middle(lines, nearest);
        return std::pair(std::atan2(side.y(), side.x()), middle(lines, nearest).z());
    };
    const auto [low, z_low] = angle_at(0.4f);
    const auto [high, z_high] = angle_at(0.6f);
    // Steps of half a spacing turn by atan(.157) instead of .157: 0.8 % less.
    CHECK(std::remainder(high - low, 2 * std::numbers::pi_v<float>) == Approx(wind * (z_high - z_low)).epsilon(0.01));
}

TEST_CASE("vortex lines are bit-identical for any number of threads", "[render][flow]") {
    Vortex v = box(Vec3f(0.625f, 0.025f, 0.525f), round_axis, everywhere);
    LineShape shape = one_line(0.04f);
    shape.seeds = 50;
    CHECK(test::same_on_threads([&] {
        const VortexLines made = vortex_lines(v.frame, v.grid, shape);
        return std::tuple(made.position, made.light, made.index);
    }));
}
