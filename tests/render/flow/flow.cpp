// The flow on a grid, and trails through it.
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "render/flow/flow_grid.h"
#include "render/flow/vortex_lines.h"
#include "tests/support/flow_frames.h"
#include "tests/support/on_threads.h"

using namespace whorl;
using namespace whorl::test;

namespace {

template <class F>
Frame cube(F&& velocity) {
    return square_or_cube(3, 0, velocity);
}

}  // namespace

TEST_CASE("the grid has the flow's velocity inside the fluid, and cover 0 outside", "[render][flow]") {
    const Frame frame = cube(turning);
    const std::vector<Eigen::Vector4f> value(frame.position.size(), Eigen::Vector4f::Constant(0.25f));
    const FlowGrid grid = flow_grid(frame, frame.velocity, value);
    // Symmetric weights reproduce a linear flow away from the faces.
    for (const Vec3f& x : {Vec3f(0.3f, 0.4f, 0.5f), Vec3f(0.71f, 0.52f, 0.33f)}) {
        const FlowGrid::Sample s = grid.at(x);
        CHECK((s.along - turning(x)).norm() < 2e-3f);
        CHECK(s.value.y() == Approx(0.25f));
        CHECK(s.cover > 0.9f);
    }
    CHECK(grid.at(Vec3f(2, 0.5f, 0.5f)).cover == 0);
}

TEST_CASE("a periodic axis of the grid joins its ends", "[render][flow]") {
    Frame frame = cube([](const Vec3f& x) { return Vec3f(0, std::sin(2 * std::numbers::pi_v<float> * x.x()), 0); });
    frame.periodic = {true, true, true};
    const FlowGrid grid = flow_grid(frame, frame.velocity, {});
    CHECK(grid.n[0] == 20);
    CHECK(grid.at(Vec3f(0.999f, 0.5f, 0.5f)).cover > 0.9f);
    // The means flatten a wave of 20 spacings by a few percent, equally on both sides of the face.
    CHECK(std::abs(grid.at(Vec3f(0.0f, 0.5f, 0.5f)).along.y()) < 1e-3f);
    CHECK(grid.at(Vec3f(0.975f, 0.5f, 0.5f)).along.y() == Approx(-grid.at(Vec3f(0.025f, 0.5f, 0.5f)).along.y()).margin(1e-4));
}

TEST_CASE("grids are bit-identical for any number of threads", "[render][flow]") {
    const Frame frame = cube(turning);
    std::vector<Eigen::Vector4f> value;
    for (const Vec3f& x : frame.position) value.push_back(Eigen::Vector4f::Constant(x.x()));
    CHECK(same_on_threads([&] { return flow_grid(frame, frame.velocity, value).value; }));
}

TEST_CASE("a grid of values alone leaves out particles far from any value, and its values are bit-identical", "[render][flow]") {
    Frame frame = cube(turning);
    std::vector<Eigen::Vector4f> value;  // in a ball at a corner, across the faces of periodic axes
    for (const Vec3f& x : frame.position)
        value.push_back(Vec3f(x - Vec3f::Constant(0.1f)).norm() < 0.22f ? Eigen::Vector4f::Ones() : Eigen::Vector4f::Zero());
    for (const bool periodic : {false, true}) {
        frame.periodic = {periodic, periodic, periodic};
        const FlowGrid whole = flow_grid(frame, frame.velocity, value), alone = flow_grid(frame, {}, value);
        CHECK(whole.value == alone.value);
        int left_out = 0;
        for (std::size_t m = 0; m < whole.value.size(); ++m) {
            if (whole.value[m][3] > 0) CHECK(whole.cover[m] == alone.cover[m]);
            left_out += alone.cover[m] < whole.cover[m];
        }
        CHECK(left_out > static_cast<int>(whole.value.size()) / 4);
    }
}

TEST_CASE("a trail in a rotating flow is an arc, as long as the path of its duration", "[render][flow]") {
    const Frame frame = cube(turning);
    const FlowGrid grid = flow_grid(frame, frame.velocity, {});
    Frame one = frame;
    one.position = {Vec3f(0.75f, 0.5f, 0.5f)};
    one.velocity = {turning(one.position[0])};
    const float seconds = 1;  // of 1 rad/s
    const Trails t = trails(one, {Vec3f::Constant(0.5f)}, grid, seconds, 0.01f, Vec3f(0.5f, 0.5f, 3));
    REQUIRE(t.position.size() == 14);
    const Vec3f end = 0.5f * (t.position[12] + t.position[13]);
    CHECK((end - Vec3f(0.5f + 0.25f * std::cos(1.0f), 0.5f - 0.25f * std::sin(1.0f), 0.5f)).norm() < 5e-3f);
    // Wide at the particle, across the view; a point at the end.
    CHECK((t.position[0] - t.position[1]).norm() == Approx(0.01f).epsilon(1e-3));
    CHECK((t.position[12] - t.position[13]).norm() < 1e-6f);
    CHECK(t.colour[0].x() == 0.5f);
}

TEST_CASE("the grid of a 2D flow is one node deep and covered, at any resolution", "[render][flow]") {
    const Frame frame = square_or_cube(2, 0, turning);
    for (const float cell : {1.0f, 0.5f}) {
        const FlowGrid grid = flow_grid(frame, frame.velocity, {}, 8'000'000, cell);
        CHECK(grid.n[2] == 1);
        CHECK(grid.at(Vec3f(0.5f, 0.5f, 0)).cover > 0.7f);  // the node is half a spacing off the plane, which costs a quarter
    }
}
