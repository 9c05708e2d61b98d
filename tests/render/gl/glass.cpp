/// Solids of glass, compared with rays by Snell's law.
#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>

#include "engine/geometry/shape.h"
#include "render/gl/renderer.h"
#include "tests/support/shapes.h"

using namespace whorl;

namespace glass_test {

constexpr float tile = 0.02f, radius = 0.05f, refraction = 1.5f;
constexpr int width = 640, height = 360;
const Vec3f centre(0, 0.08f, 0);
const View view{Vec3f(0, 0.3f, 0.5f), Vec3f(0, 0.05f, 0), Vec3f(0, 1, 0), 30};

/// A board of dark and white tiles whose top is at y = 0, and the ball above it.
Frame board() {
    Frame frame;
    frame.spacing = 0.005f;
    frame.domain_min = Vec3f(-0.2f, -0.01f, -0.2f), frame.domain_max = Vec3f(0.2f, 0.2f, 0.2f);
    frame.solids = test::chequered_board(tile);
    frame.solids.push_back(test::solid_of(make_sphere(centre.cast<double>(), static_cast<double>(radius))->mesh(Real(0.001), 0), "glass"));
    return frame;
}

/// Refracts the unit vector d at a surface whose unit normal n faces it. @param ratio of the indices of refraction before and behind
Vec3f refracted(const Vec3f& d, const Vec3f& n, float ratio) {
    const float c = -n.dot(d);
    return ratio * d + (ratio * c - std::sqrt(1 - ratio * ratio * (1 - c * c))) * n;
}

/// Whether the centre of the pixel shows a white tile (1) or a dark one (0) through the ball; -1: it does not, or near the ball's edge or
/// at a place that the image does not show.
int expected(int x, int y) {
    const Vec3f ahead = (view.target - view.position).normalized(), right = ahead.cross(view.up).normalized(), up = right.cross(ahead);
    const float tangent = std::tan(view.fov * static_cast<float>(M_PI) / 360), size = tangent * 2 / static_cast<float>(height);
    const float across = (static_cast<float>(x) + 0.5f - width / 2) * size, down = (static_cast<float>(y) + 0.5f - height / 2) * size;
    Vec3f d = (ahead + across * right - down * up).normalized();
    const Vec3f from = view.position - centre;
    const float b = from.dot(d), inner = b * b - from.squaredNorm() + radius * radius;
    if (inner < (1 - 0.8f * 0.8f) * radius * radius) return -1;
    Vec3f at = from + (-b - std::sqrt(inner)) * d;
    d = refracted(d, at / radius, 1 / refraction);
    at -= 2 * at.dot(d) * d;
    d = refracted(d, -at / radius, refraction);
    if (d.y() > -0.05f) return -1;
    const Vec3f q = at + centre - (at + centre).y() / d.y() * d, seen = q - view.position;
    const float away = seen.dot(ahead);
    if (q.cwiseAbs().maxCoeff() > 0.19f || std::abs(seen.dot(up)) > 0.95f * tangent * away) return -1;
    return static_cast<int>(std::floor(q.x() / tile) + std::floor(q.z() / tile)) & 1;
}

TEST_CASE("a glass ball shows the tiles behind it where Snell's law puts them, within 2 pixels", "[render][glass]") {
    Renderer renderer(width, height);
    LookOptions look;
    look.samples = 1;
    const Image image = renderer.draw(board(), {}, look, view);
    int shown = 0, wrong = 0;
    for (int y = 3; y < height - 3; ++y)
        for (int x = 3; x < width - 3; ++x) {
            const int white = expected(x, y);
            if (white < 0) continue;
            ++shown;
            // Wrong is a pixel that no pixel up to 2 away should look like.
            const bool light = image.pixel(x, y)[1] > 110;
            bool near = false;
            for (int dy = -2; dy <= 2; ++dy)
                for (int dx = -2; dx <= 2; ++dx) near = near || expected(x + dx, y + dy) < 0 || (expected(x + dx, y + dy) == 1) == light;
            wrong += !near;
        }
    INFO("pixels that show tiles through the ball: " << shown);
    CHECK(shown > 3000);
    CHECK(wrong == 0);
}

TEST_CASE("honey fills a thick open glass to its outline, as light is bent from air to glass to honey", "[render][glass]") {
    // A ray that grazes the outside meets the cavity if its radius is more than that of the outside divided by the index, 2/3 of it.
    constexpr float inner = 0.036f, wall = 0.009f, spacing = 0.003f, filled = 0.06f;
    ShapeKeys keys;
    keys.kind = "cylinder", keys.open = "top", keys.wall = static_cast<double>(wall), keys.radius = static_cast<double>(inner);
    keys.from = {0, 0, 0}, keys.to = {0, 0.09, 0};
    Frame frame;
    frame.spacing = spacing;
    frame.domain_min = Vec3f(-0.2f, -0.01f, -0.2f), frame.domain_max = Vec3f(0.2f, 0.2f, 0.2f);
    frame.solids.push_back(test::solid_of(make_shape(keys)->mesh(Real(0.002), 0), "glass"));
    // A second glass, out of the image, makes the grid of the distance field three times as long.
    if (GENERATE(false, true)) frame.solids.push_back(test::solid_of(make_sphere({0.3, 0.02, 0}, 0.02)->mesh(Real(0.002), 0), "glass"));
    for (float y = spacing / 2; y < filled; y += spacing)
        for (float x = -inner; x < inner; x += spacing)
            for (float z = -inner; z < inner; z += spacing)
                if (std::hypot(x, z) < inner - spacing / 2) frame.position.emplace_back(x, y, z);
    const View side{Vec3f(0, 0.04f, 0.8f), Vec3f(0, 0.04f, 0), Vec3f(0, 1, 0), 12};
    LookOptions look;
    look.material = "honey", look.samples = 1;
    const Image image = Renderer(width, height).draw(frame, build_surface(frame, {}), look, side);
    // Half width of the outline, seen from 0.8 m.
    const float scale = static_cast<float>(height) / 2 / std::tan(12 * static_cast<float>(M_PI) / 360), outer = inner + wall;
    const int reach = static_cast<int>(0.96f * scale * outer / std::sqrt(0.64f - outer * outer));
    int clear = 0;
    for (int x = width / 2 - reach; x <= width / 2 + reach; ++x)
        for (int y = height / 2 - 20; y < height / 2 + 20; ++y) {
            const auto* pixel = image.pixel(x, y);
            clear += pixel[0] - pixel[2] < 60 ? 1 : 0;
        }
    INFO("pixels without the colour of honey, in " << 2 * reach + 1 << " x 40 within the outline");
    CHECK(clear == 0);
}

TEST_CASE("a dark post behind a slanted plate of glass is seen once, without a faint outline at its true place", "[render][glass]") {
    // The plate moves the post sideways by half a dozen pixels. Pixels beside it look as without it, within four steps of 256.
    Frame frame;
    frame.spacing = 0.005f;
    frame.domain_min = Vec3f(-0.1f, -0.1f, -0.1f), frame.domain_max = Vec3f(0.1f, 0.1f, 0.2f);
    frame.solids.push_back(test::solid_of(test::box_mesh(Vec3f(-0.2f, -0.2f, -0.01f), Vec3f(0.2f, 0.2f, 0.01f)), "glass"));
    frame.solids[0].rotation = Eigen::AngleAxisf(0.6f, Vec3f::UnitY()).toRotationMatrix(), frame.solids[0].translation = Vec3f(0, 0, 0.15f);
    const View front{Vec3f(0, 0, 0.6f), Vec3f::Zero(), Vec3f(0, 1, 0), 14};
    LookOptions look;
    look.samples = 4, look.ground = false;
    constexpr int w = width / 2, h = height / 2;
    Renderer renderer(w, h);
    const Image empty = renderer.draw(frame, {}, look, front);
    frame.solids.push_back(test::solid_of(test::box_mesh(Vec3f(-0.008f, -0.15f, -0.008f), Vec3f(0.008f, 0.15f, 0.008f)), "dark"));
    const Image image = renderer.draw(frame, {}, look, front);
    int beside = 0, shown = 0;
    for (int y = 30; y < h - 30; ++y) {
        int first = w, last = 0;
        const auto differs = [&](int x) { return std::abs(image.pixel(x, y)[1] - empty.pixel(x, y)[1]); };
        for (int x = 75; x < w - 75; ++x)
            if (differs(x) > 60) first = std::min(first, x), last = std::max(last, x);
        shown += last - first;
        for (int x = 75; x < w - 75; ++x) beside += (x < first - 3 || x > last + 3) && differs(x) > 4 ? 1 : 0;
    }
    INFO("pixels of the post: " << shown);
    CHECK(shown > 15 * (h - 60));
    CHECK(shown < 30 * (h - 60));
    CHECK(beside == 0);
}

}  // namespace glass_test
