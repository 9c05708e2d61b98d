/// Several solids of glass with different indices and tints, compared with rays by Snell's law and Beer's law.
#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <optional>

#include "engine/geometry/shape.h"
#include "render/gl/renderer.h"
#include "render/look/material.h"
#include "tests/support/shapes.h"

using namespace whorl;

namespace nested_glass_test {

constexpr float tile = 0.02f;
constexpr int width = 640, height = 360;

struct Ball {
    Vec3f centre;
    float radius, index;
    Vec3f colour;
    Vec3f absorption = Vec3f::Zero();
};

/// A ball of ice in a ball of glass, which a second ball of glass intersects. Smaller ones come first.
std::vector<Ball> balls() {
    return {{Vec3f(0.008f, 0.086f, 0.005f), 0.022f, 1.31f, Vec3f(0.9f, 0.5f, 0.5f)},
            {Vec3f(0.055f, 0.06f, -0.03f), 0.03f, 1.5f, Vec3f(0.6f, 0.6f, 0.95f)},
            {Vec3f(0, 0.08f, 0), 0.05f, 1.5f, Vec3f(0.6f, 0.9f, 0.7f)}};
}

/// Adds the balls to the frame, and their absorption to the list. @param exact their meshes are those of balls, to the last vertex
void add(std::vector<Ball>& list, bool exact, const std::optional<Vec3f>& colour, Frame& frame) {
    for (Ball& ball : list) {
        TriangleMesh mesh = make_sphere(ball.centre.cast<double>(), static_cast<double>(ball.radius))->mesh(Real(0.001), 0);
        if (!exact)
            mesh.position[mesh.position.size() / 2] = ball.centre + 0.998f * (mesh.position[mesh.position.size() / 2] - ball.centre);
        FrameSolid solid = test::solid_of(std::move(mesh), ball.index < 1.4f ? "ice" : "glass");
        const Vec3f tint = colour.value_or(ball.colour);
        solid.appearance.colour = Colour(tint.x(), tint.y(), tint.z()), solid.appearance.roughness = 0;
        ball.absorption = solid_material(solid.appearance).absorption;
        frame.solids.push_back(solid);
    }
}

struct Traced {
    bool clear = false;  ///< the ray passes through a ball, meets no surface at a grazing angle, and is not totally reflected
    Vec3f from = Vec3f::Zero(), way = Vec3f::Zero();
    Vec3f transmitted = Vec3f::Ones();
};

Traced trace(const std::vector<Ball>& list, const Vec3f& eye, const Vec3f& direction) {
    Traced ray{false, eye, direction};
    const auto ball_at = [&](const Vec3f& x) {
        for (const Ball& ball : list)
            if ((x - ball.centre).norm() < ball.radius) return &ball;
        return static_cast<const Ball*>(nullptr);
    };
    const Ball* medium = nullptr;
    for (int turn = 0; turn < 12; ++turn) {
        float first = 1e6f;
        const Ball* met = nullptr;
        for (const Ball& ball : list) {
            const Vec3f from = ray.from - ball.centre;
            const float b = from.dot(ray.way), square = b * b - from.squaredNorm() + ball.radius * ball.radius;
            for (const float root : {-1.0f, 1.0f})
                if (const float t = -b + root * std::sqrt(std::max(square, 0.0f)); square > 0 && t > 1e-5f && t < first)
                    first = t, met = &ball;
        }
        if (met == nullptr) return ray;
        ray.from += first * ray.way;
        if (medium != nullptr) ray.transmitted.array() *= (-first * medium->absorption).array().exp();
        const Ball* next = ball_at(ray.from + 2e-5f * ray.way);
        const float ratio = (medium != nullptr ? medium->index : 1) / (next != nullptr ? next->index : 1);
        Vec3f n = (ray.from - met->centre).normalized();
        if (n.dot(ray.way) > 0) n = -n;
        const float c = -n.dot(ray.way), square = 1 - ratio * ratio * (1 - c * c);
        if (c < 0.5f || square < 0.2f) return {};
        if (medium != next) ray.way = (ratio * ray.way + (ratio * c - std::sqrt(square)) * n).normalized();
        medium = next;
        ray.clear = true;
    }
    return {};
}

/// Direction from the eye through the centre of a pixel.
Vec3f direction_of(const View& view, int x, int y) {
    const Vec3f ahead = (view.target - view.position).normalized(), right = ahead.cross(view.up).normalized(), up = right.cross(ahead);
    const float size = std::tan(view.fov * static_cast<float>(M_PI) / 360) * 2 / static_cast<float>(height);
    const float across = (static_cast<float>(x) + 0.5f - width / 2) * size, down = (static_cast<float>(y) + 0.5f - height / 2) * size;
    return (ahead + across * right - down * up).normalized();
}

/// Whether the pixel shows a white tile (1) or a dark one (0) through the balls; -1: neither.
int expected_tile(const std::vector<Ball>& list, const View& view, int x, int y) {
    const Traced ray = trace(list, view.position, direction_of(view, x, y));
    if (!ray.clear || ray.way.y() > -0.05f) return -1;
    const Vec3f q = ray.from - ray.from.y() / ray.way.y() * ray.way, seen = q - view.position;
    const Vec3f ahead = (view.target - view.position).normalized(), up = ahead.cross(view.up).normalized().cross(ahead);
    const float away = seen.dot(ahead), tangent = std::tan(view.fov * static_cast<float>(M_PI) / 360);
    if (q.cwiseAbs().maxCoeff() > 0.19f || std::abs(seen.dot(up)) > 0.95f * tangent * away) return -1;
    return static_cast<int>(std::floor(q.x() / tile) + std::floor(q.z() / tile)) & 1;
}

Frame empty_frame() {
    Frame frame;
    frame.spacing = 0.005f;
    frame.domain_min = Vec3f(-0.2f, -0.01f, -0.2f), frame.domain_max = Vec3f(0.2f, 0.2f, 0.2f);
    return frame;
}

TEST_CASE("ice in glass, and glass that touches it, show tiles where Snell's law puts them, within 2 pixels", "[render][glass]") {
    const bool exact = GENERATE(true, false);
    const View view{Vec3f(0, 0.3f, 0.5f), Vec3f(0, 0.05f, 0), Vec3f(0, 1, 0), 30};
    std::vector<Ball> list = balls();
    Frame frame = empty_frame();
    frame.solids = test::chequered_board(tile);
    add(list, exact, Vec3f::Ones(), frame);
    LookOptions look;
    look.samples = 1;
    const Image image = Renderer(width, height).draw(frame, {}, look, view);
    std::vector<int> tiles(static_cast<std::size_t>(width * height), -1);
    const auto at = [&](int x, int y) -> int& { return tiles[static_cast<std::size_t>(y * width + x)]; };
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) at(x, y) = expected_tile(list, view, x, y);
    int shown = 0, wrong = 0;
    for (int y = 2; y < height - 2; ++y)
        for (int x = 2; x < width - 2; ++x) {
            if (at(x, y) < 0) continue;
            ++shown;
            // Wrong is a pixel that no pixel up to 2 away should look like.
            const int white = image.pixel(x, y)[1] > 110 ? 1 : 0;
            bool near = false;
            for (int dy = -2; dy <= 2; ++dy)
                for (int dx = -2; dx <= 2; ++dx) near = near || at(x + dx, y + dy) < 0 || at(x + dx, y + dy) == white;
            wrong += near ? 0 : 1;
        }
    INFO("pixels that show tiles through the balls: " << shown << ", wrong " << wrong << (exact ? ", exact" : ", distance field"));
    CHECK(shown > 3000);
    CHECK(wrong == 0);
}

TEST_CASE("each glass along a ray takes its own part of the light, within 2 % of the light without tints", "[render][glass]") {
    const bool exact = GENERATE(true, false);
    const View view{Vec3f(0, 0.09f, 0.6f), Vec3f(0.01f, 0.075f, 0), Vec3f(0, 1, 0), 15};
    LookOptions look;
    look.samples = 1, look.ground = false;
    Renderer renderer(width, height);
    std::vector<Ball> list = balls();
    const auto light = [&](const std::optional<Vec3f>& colour) {
        Frame frame = empty_frame();
        add(list, exact, colour, frame);
        return renderer.draw_layers(frame, {}, look, view, {view, 0.04f}).light;
    };
    // The black balls show only what their fronts reflect.
    const std::vector<float> clear = light(Vec3f::Ones()), black = light(Vec3f::Zero()), tinted = light({});
    int shown = 0, wrong = 0;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const Traced ray = trace(list, view.position, direction_of(view, x, y));
            if (!ray.clear) continue;
            for (int band = 0; band < 3; ++band) {
                const auto k = static_cast<std::size_t>(4 * (y * width + x) + band);
                const float all = clear[k] - black[k];
                if (all < 0.05f) continue;
                ++shown;
                wrong += std::abs((tinted[k] - black[k]) / all - ray.transmitted[band]) > 0.02f ? 1 : 0;
            }
        }
    INFO("bands of pixels: " << shown << ", wrong " << wrong << (exact ? ", exact" : ", distance field"));
    CHECK(shown > 20000);
    CHECK(wrong < shown / 200);  // at outlines of the balls inside
}

TEST_CASE("an opaque ball inside a block of glass is seen at the depth that its flat front gives it, within 2 pixels", "[render][glass]") {
    // From 0.6 m, what is 0.03 m behind the front seems to be 0.03/1.5 m behind it: the ball of 0.01 m is 0.01/0.59 of the distance.
    Frame frame = empty_frame();
    frame.solids.push_back(test::solid_of(test::box_mesh(Vec3f(-0.03f, -0.03f, -0.03f), Vec3f(0.03f, 0.03f, 0.03f)), "glass"));
    frame.solids.push_back(test::solid_of(make_sphere(Vec3d::Zero(), 0.01)->mesh(Real(0.001), 0), "dark"));
    const View view{Vec3f(0, 0, 0.6f), Vec3f::Zero(), Vec3f(0, 1, 0), 8};
    LookOptions look;
    look.ground = false;
    const Image image = Renderer(width, height).draw(frame, {}, look, view);
    int first = width, last = 0;
    for (int x = width / 2 - 100; x < width / 2 + 100; ++x)
        if (image.pixel(x, height / 2)[1] < 110) first = std::min(first, x), last = std::max(last, x);
    const int dark = last - first + 1;
    const float expected = 0.01f / 0.59f / std::tan(4 * static_cast<float>(M_PI) / 180) * static_cast<float>(height);
    INFO("pixels across the ball: " << dark << ", expected " << expected);
    CHECK(std::abs(static_cast<float>(dark) - expected) < 4);  // 2 at either side, as for tiles
}

}  // namespace nested_glass_test
