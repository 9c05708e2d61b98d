// The flow on a grid, its streaks, slices and trails.
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "engine/core/parallel.h"
#include "render/flow/slice.h"
#include "render/flow/streaks.h"
#include "render/flow/trails.h"

using namespace whorl;

namespace {

/// A cube of 1 m, 20 particles wide, with a velocity of places.
template <class F>
Frame cube(F&& velocity) {
    Frame frame;
    frame.spacing = 0.05f;
    frame.domain_min = Vec3f::Zero(), frame.domain_max = Vec3f::Ones();
    for (int k = 0; k < 20; ++k)
        for (int j = 0; j < 20; ++j)
            for (int i = 0; i < 20; ++i) {
                frame.position.push_back(0.05f *
                                         Vec3f(static_cast<float>(i) + 0.5f, static_cast<float>(j) + 0.5f, static_cast<float>(k) + 0.5f));
                frame.velocity.push_back(velocity(frame.position.back()));
            }
    return frame;
}

Vec3f turning(const Vec3f& x) { return Vec3f(0.5f - x.y(), x.x() - 0.5f, 0); }

}  // namespace

TEST_CASE("the grid has the flow's velocity inside, and no cover where no fluid is", "[render][flow]") {
    const Frame frame = cube(turning);
    const std::vector<float> value(frame.position.size(), 0.25f);
    const FlowGrid grid = flow_grid(frame, value);
    // A linear flow: symmetric weights give it back away from the faces.
    for (const Vec3f& x : {Vec3f(0.3f, 0.4f, 0.5f), Vec3f(0.71f, 0.52f, 0.33f)}) {
        const FlowGrid::Sample s = grid.at(x);
        CHECK((s.velocity - turning(x)).norm() < 2e-3f);
        CHECK(s.value == Approx(0.25f));
        CHECK(s.cover > 0.9f);
    }
    CHECK(grid.at(Vec3f(2, 0.5f, 0.5f)).cover == 0);
}

TEST_CASE("a periodic axis of the grid joins its ends", "[render][flow]") {
    Frame frame = cube([](const Vec3f& x) { return Vec3f(0, std::sin(2 * std::numbers::pi_v<float> * x.x()), 0); });
    frame.periodic = {true, true, true};
    const FlowGrid grid = flow_grid(frame, std::vector<float>(frame.position.size(), 1.0f));
    CHECK(grid.n[0] == 20);
    CHECK(grid.at(Vec3f(0.999f, 0.5f, 0.5f)).cover > 0.9f);
    // The means flatten a wave of 20 spacings by a few percent: the same on both sides of the joint.
    CHECK(std::abs(grid.at(Vec3f(0.0f, 0.5f, 0.5f)).velocity.y()) < 1e-3f);
    CHECK(grid.at(Vec3f(0.975f, 0.5f, 0.5f)).velocity.y() == Approx(-grid.at(Vec3f(0.025f, 0.5f, 0.5f)).velocity.y()).margin(1e-4));
}

TEST_CASE("grids, slices and trails are the same bits for any number of threads", "[render][flow]") {
    const Frame frame = cube(turning);
    std::vector<float> value;
    for (const Vec3f& x : frame.position) value.push_back(x.x());
    LookOptions look;
    look.style = "slice";
    const int before = threads();
    set_threads(1);
    const FlowGrid one = flow_grid(frame, value);
    const FlowSlice slice_one = flow_slice(one, look, 128);
    set_threads(4);
    const FlowGrid four = flow_grid(frame, value);
    CHECK(four.value == one.value);
    CHECK(flow_slice(four, look, 128).rgba == slice_one.rgba);
    set_threads(before);
}

TEST_CASE("streaks run along the flow: brightness varies slowly that way and fast across", "[render][flow]") {
    const int n = 96;
    const std::vector<Eigen::Vector2f> along_x(n * n, Eigen::Vector2f(1, 0));
    const std::vector<float> b = streaks(along_x, n, n, 12);
    double along = 0, across = 0;
    for (int y = 20; y < 70; ++y)
        for (int x = 20; x < 70; ++x) {
            const auto at = [&](int i, int j) { return b[j * n + i]; };
            along += std::pow(at(x + 1, y) - at(x, y), 2.0), across += std::pow(at(x, y + 1) - at(x, y), 2.0);
        }
    // Two means of 25 pixels that share 24 differ by 2/25 of the variance of those that share none... in squares.
    CHECK(along < 0.15 * across);
    // Still water has no streaks.
    const std::vector<float> still = streaks(std::vector<Eigen::Vector2f>(n * n, Eigen::Vector2f::Zero()), n, n, 12);
    CHECK(still.size() == b.size());
}

TEST_CASE("a trail in a turning flow is an arc as long as the way of its time", "[render][flow]") {
    const Frame frame = cube(turning);
    const FlowGrid grid = flow_grid(frame, std::vector<float>(frame.position.size(), 0.0f));
    Frame one = frame;
    one.position = {Vec3f(0.75f, 0.5f, 0.5f)};
    one.velocity = {turning(one.position[0])};
    const float seconds = 1;  // of 1 rad/s
    const Trails t = trails(one, {0.5f}, grid, seconds, 0.01f, Vec3f(0.5f, 0.5f, 3));
    REQUIRE(t.position.size() == 14);
    const Vec3f end = 0.5f * (t.position[12] + t.position[13]);
    CHECK((end - Vec3f(0.5f + 0.25f * std::cos(1.0f), 0.5f - 0.25f * std::sin(1.0f), 0.5f)).norm() < 5e-3f);
    // Wide at the particle, across the view; a point at the end.
    CHECK((t.position[0] - t.position[1]).norm() == Approx(0.01f).epsilon(1e-3));
    CHECK((t.position[12] - t.position[13]).norm() < 1e-6f);
    CHECK(t.value[0] == 0.5f);
}

TEST_CASE("a slice has the colours of the field where it stands", "[render][flow]") {
    const Frame frame = cube([](const Vec3f&) { return Vec3f::Zero().eval(); });
    std::vector<float> value;
    for (const Vec3f& x : frame.position) value.push_back(x.z());
    const FlowGrid grid = flow_grid(frame, value);
    LookOptions look;
    look.style = "slice";
    CHECK(slice_position(grid, look) == Approx(0.5f).margin(0.03f));
    look.slice_position = 0.2f;
    const FlowSlice low = flow_slice(grid, look, 64);
    look.slice_position = 0.9f;
    const FlowSlice high = flow_slice(grid, look, 64);
    const std::size_t middle = 4 * static_cast<std::size_t>(low.height / 2 * low.width + low.width / 2);
    CHECK(low.rgba[middle + 3] > 0.9f);
    CHECK(high.rgba[middle] > low.rgba[middle] + 0.3f);  // viridis ends yellow
}
