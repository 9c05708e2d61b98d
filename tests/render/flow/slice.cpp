// Slices: fields in the pixels of a plane, streaks along the flow, sections of solids.
#include "render/flow/slice.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "render/flow/marks.h"
#include "render/image/image.h"
#include "tests/support/flow_frames.h"
#include "tests/support/on_threads.h"
#include "tests/support/shapes.h"

using namespace whorl;

namespace slice_test {

namespace {

/// Uneven particles.
template <class F>
Frame uneven(int dimensions, F&& velocity) {
    return test::square_or_cube(dimensions, 0.3f, velocity);
}

using test::turning;

/// Largest difference from a function of position, over pixels at least `margin` from the edge.
template <class F>
float largest_error(const std::vector<float>& value, const PixelPlane& plane, int margin, F&& expected) {
    float most = 0;
    for (int y = margin; y < plane.height - margin; ++y)
        for (int x = margin; x < plane.width - margin; ++x) {
            const Vec3f at =
                plane.corner + plane.pixel * ((static_cast<float>(x) + 0.5f) * plane.right + (static_cast<float>(y) + 0.5f) * plane.up);
            most = std::max(most, std::abs(value[grid_index(x, y, plane.width)] - expected(at)));
        }
    return most;
}

double mean_square(const std::vector<float>& v) {
    double sum = 0;
    for (const float one : v) sum += static_cast<double>(one) * one;
    return sum / static_cast<double>(v.size());
}

}  // namespace

TEST_CASE("a linear field is exact in every pixel, also at the edges, in 2D and 3D", "[render][slice]") {
    LookOptions look;
    for (const int dimensions : {2, 3})
        for (const char* axis : {"x", "y", "z"}) {
            look.slice_axis = axis;
            if (dimensions == 2 && look.slice_axis != "z") continue;
            look.slice_position = 0.43f;
            const Frame frame = uneven(dimensions, turning);
            const auto linear = [&](const Vec3f& x) { return 2 + 3 * x.x() - x.y() + (dimensions == 3 ? 0.7f * x.z() : 0.0f); };
            std::vector<float> value;
            for (const Vec3f& x : frame.position) value.push_back(linear(x));
            const PixelPlane plane = slice_plane(frame, look, 150);
            const PlaneField field = plane_field(frame, {value}, plane);
            INFO(dimensions << " dimensions, axis " << axis);
            // The regularisation of the gradients is 1e-4.
            CHECK(largest_error(field.value[0], plane, 0, linear) < 1e-3f);
            CHECK(largest_error(field.velocity[0], plane, 0, [&](const Vec3f& x) { return turning(x).dot(plane.right); }) < 1e-3f);
            CHECK(largest_error(field.cover, plane, 15, [](const Vec3f&) { return 1.0f; }) < 0.35f);
        }
}

TEST_CASE("values of inks stay in their range at a border, and linear fields stay exact", "[render][slice]") {
    const Frame frame = uneven(2, turning);
    std::vector<float> step, linear;
    for (const Vec3f& x : frame.position)
        step.push_back(x.x() + 0.4f * x.y() > 0.6f ? 1.0f : 0.0f), linear.push_back(2 + 3 * x.x() - x.y());
    const PixelPlane plane = slice_plane(frame, {}, 150);
    const PlaneField free = plane_field(frame, {step, linear}, plane), bounded = plane_field(frame, {step, linear}, plane, true);
    const auto outside = [](const std::vector<float>& value) {  // largest distance from 0 .. 1
        float most = 0;
        for (const float v : value) most = std::max({most, -v, v - 1});
        return most;
    };
    CHECK(outside(free.value[0]) > 0.05f);
    CHECK(outside(bounded.value[0]) == 0);
    // At the edges the particles that would continue the field are missing, and the gradient is shortened.
    CHECK(largest_error(bounded.value[1], plane, 15, [](const Vec3f& x) { return 2 + 3 * x.x() - x.y(); }) < 1e-3f);
}

TEST_CASE("a slice continues across a periodic face", "[render][slice]") {
    Frame frame = uneven(2, turning);
    frame.periodic = {true, true, false};
    std::vector<float> value;
    for (const Vec3f& x : frame.position) value.push_back(std::sin(6.2831853f * x.x()));
    const PixelPlane plane = slice_plane(frame, LookOptions{}, 200);
    const PlaneField field = plane_field(frame, {value}, plane);
    // A mean over two spacings flattens the curvature of a wave of 20 spacings by 2 %.
    CHECK(largest_error(field.value[0], plane, 0, [](const Vec3f& x) { return std::sin(6.2831853f * x.x()); }) < 0.06f);
    CHECK(*std::min_element(field.cover.begin(), field.cover.end()) > 0.6f);
}

TEST_CASE("a slice shows the box of the camera, or the whole domain without one", "[render][slice]") {
    const Frame frame = uneven(2, turning);
    const ShownBox box{Vec3f(0.25f, 0.5f, 0), Vec3f(0.75f, 0.75f, 0)};
    const PixelPlane part = slice_plane(frame, LookOptions{}, 200, box), whole = slice_plane(frame, LookOptions{}, 200);
    CHECK(part.corner == Vec3f(0.25f, 0.5f, 0));
    CHECK((part.width == 200 && part.height == 100));
    CHECK(part.pixel == Approx(0.5f / 200));
    CHECK(whole.corner.head<2>() == frame.domain_min.head<2>());
}

TEST_CASE("slices are bit-identical for any number of threads", "[render][slice]") {
    const Frame frame = uneven(2, turning);
    LookOptions look;
    look.style = "slice";
    const PixelPlane plane = slice_plane(frame, look, 128);
    CHECK(test::same_on_threads([&] { return flow_slice(frame, look, {0, 1}, plane, Vec3f::Ones()).rgba; }));
}

TEST_CASE("noise has mean 0 and variance 1 and moves with the particles", "[render][slice]") {
    Frame frame = uneven(2, turning);
    frame.periodic = {true, true, false};
    const PixelPlane plane = slice_plane(frame, LookOptions{}, 400);
    const PlaneField first = plane_field(frame, {std::vector<float>(frame.position.size())}, plane);
    REQUIRE_FALSE(first.noise.empty());
    CHECK(mean_square(first.noise) == Approx(1).epsilon(0.1));
    // All particles go 10 pixels to the right, and all the noise with them.
    for (Vec3f& x : frame.position) x.x() += 10 * plane.pixel;
    const PlaneField second = plane_field(frame, {std::vector<float>(frame.position.size())}, plane);
    float most = 0;
    for (int y = 0; y < plane.height; ++y)
        for (int x = 0; x + 10 < plane.width; ++x)
            most = std::max(most, std::abs(second.noise[grid_index(x + 10, y, plane.width)] - first.noise[grid_index(x, y, plane.width)]));
    CHECK(most < 0.02f);
}

TEST_CASE("streaks run along the flow, and vanish at rest", "[render][slice]") {
    const Frame moving = uneven(2, [](const Vec3f&) { return Vec3f(1, 0, 0); }),
                still = uneven(2, [](const Vec3f&) { return Vec3f(Vec3f::Zero()); });
    const PixelPlane plane = slice_plane(moving, LookOptions{}, 300);
    const std::vector<float> none(moving.position.size());
    const std::vector<float> b = streaks(plane_field(moving, {none}, plane), 15 * plane.pixel, plane.pixel);
    double along = 0, across = 0;
    for (int y = 50; y < 250; ++y)
        for (int x = 50; x < 250; ++x) {
            const auto at = [&](int i, int j) { return b[grid_index(i, j, plane.width)]; };
            along += std::pow(at(x + 1, y) - at(x, y), 2.0), across += std::pow(at(x, y + 1) - at(x, y), 2.0);
        }
    // Streaks are 30 pixels long and two or three wide.
    CHECK(along < 0.1 * across);
    CHECK(mean_square(b) == Approx(1).epsilon(0.5));
    CHECK(mean_square(streaks(plane_field(still, {none}, plane), 1, plane.pixel)) == 0);
}

TEST_CASE("fluid at rest looks the same in every frame, and moving fluid nearly so", "[render][slice]") {
    // A vortex in the middle of fluid at rest; 1/24 s between frames.
    const auto vortex = [](const Vec3f& x) { return Vec3f(std::exp(-20 * (x - Vec3f(0.5f, 0.5f, 0)).squaredNorm()) * turning(x)); };
    Frame frame = uneven(2, vortex);
    LookOptions look;
    look.style = "slice";
    look.streak_time = 0.2f;
    look.range = {0, 0.2f};
    const Image first = draw_slice_image(frame, look, look.range, {400, 400});
    for (std::size_t p = 0; p < frame.position.size(); ++p) frame.position[p] += frame.velocity[p] / 24;
    for (std::size_t p = 0; p < frame.position.size(); ++p) frame.velocity[p] = vortex(frame.position[p]);
    const Image second = draw_slice_image(frame, look, look.range, {400, 400});
    const auto corner = [](const Image& image) {  // 0.45 m from the vortex: it turns there by less than 0.01 m/s
        Image part = plain_image(60, 60, 0);
        for (int y = 0; y < 60; ++y)
            for (int x = 0; x < 60; ++x) std::copy_n(image.pixel(x, y), 3, part.pixel(x, y));
        return part;
    };
    CHECK(difference(corner(first), corner(second)).mean < 0.3);
    CHECK(difference(first, second).mean < 3);
}

TEST_CASE("sections of solids have the right size", "[render][slice]") {
    Frame frame = uneven(3, turning);
    frame.solids = {test::solid_of(test::sphere(Vec3f::Constant(0.5f), 0.25f, 0.02f).mesh)};
    LookOptions look;
    look.slice_position = 0.65f;
    const PixelPlane plane = slice_plane(frame, look, 200);
    const std::vector<SolidSection> cuts = section_solids(frame, plane, 2);
    REQUIRE(cuts.size() == 1);
    double area = 0, line = 0;
    for (const float share : cuts[0].inside) area += share;
    for (const float share : cuts[0].outline) line += share;
    const double radius = 200 * 0.2;  // sqrt(0.25^2 - 0.15^2) m
    CHECK(area == Approx(3.14159 * radius * radius).epsilon(0.01));
    CHECK(line == Approx(2 * 2 * 3.14159 * radius).epsilon(0.05));
    look.slice_position = 0.9f;
    CHECK(section_solids(frame, slice_plane(frame, look, 200), 2).empty());
}

TEST_CASE("a slice without a position is in the middle of the fluid, in 2D in the plane", "[render][slice]") {
    LookOptions look;
    look.slice_axis = "y";
    Frame frame = uneven(3, turning);
    for (Vec3f& x : frame.position) x.y() = 0.2f + 0.25f * x.y();  // 0.2 to 0.45 m
    CHECK(slice_plane(frame, look, 50).corner.y() == Approx(0.325f).margin(0.02));
    look.slice_axis = "z";
    CHECK(slice_plane(uneven(2, turning), look, 50).corner.z() == 0);
}

}  // namespace slice_test
