/// Lights that a scene names: their strength, images, shadows and colours.
#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>

#include "render/gl/renderer.h"
#include "render/look/lamps.h"
#include "tests/support/shapes.h"

using namespace whorl;

namespace lights_test {

constexpr int width = 320, height = 240;
const View view{Vec3f(0, 0.3f, 0.4f), Vec3f::Zero(), Vec3f(0, 1, 0), 30};

Light soft_box(const Vec3f& position, const std::array<float, 2>& size) {
    Light light;
    light.position = position, light.size = size, light.target = Vec3f::Zero();
    return light;
}

/// A board with its top at y = 0, lit by these lights alone.
Image board(const std::vector<Light>& lights, const std::string& material, float roughness, const std::vector<FrameSolid>& others = {}) {
    Frame frame;
    frame.spacing = 0.005f;
    frame.domain_min = Vec3f(-0.4f, -0.01f, -0.4f), frame.domain_max = Vec3f(0.4f, 0.3f, 0.4f);
    frame.solids.push_back(test::solid_of(test::box_mesh(Vec3f(-0.3f, -0.01f, -0.3f), Vec3f(0.3f, 0, 0.3f)), material));
    frame.solids[0].appearance.roughness = roughness;
    frame.solids.insert(frame.solids.end(), others.begin(), others.end());
    LookOptions look;
    look.samples = 1, look.surround_strength = 0, look.lights = lights;
    Renderer renderer(width, height);
    return renderer.draw(frame, {}, look, view);
}

/// Direction of the ray through the centre of a pixel.
Vec3f ray(int x, int y) {
    const Vec3f ahead = (view.target - view.position).normalized(), right = ahead.cross(view.up).normalized(), up = right.cross(ahead);
    const float size = std::tan(view.fov * static_cast<float>(M_PI) / 360) * 2 / static_cast<float>(height);
    const float across = (static_cast<float>(x) + 0.5f - width / 2) * size, down = (static_cast<float>(y) + 0.5f - height / 2) * size;
    return (ahead + across * right - down * up).normalized();
}

/// The pixel at which a point is seen.
std::array<int, 2> pixel_of(const Vec3f& point) {
    std::array<int, 2> best{};
    float most = -1;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            if (const float along = ray(x, y).dot((point - view.position).normalized()); along > most) most = along, best = {x, y};
    return best;
}

TEST_CASE("lights of all kinds illuminate their target alike, with a radiance that follows from their size", "[look]") {
    Light box = soft_box(Vec3f(0, 0.3f, 0.4f), {0.2f, 0.1f}), lamp = box, sun;
    lamp.kind = "lamp", lamp.radius = 0.01f, sun.kind = "sun", sun.direction = Vec3f(0, -2, 0), sun.angle = 4;
    box.strength = lamp.strength = sun.strength = 2;
    const std::vector<Lamp> lamps = lamps_of({box, lamp, sun});
    const float distance = 0.5f, pi = static_cast<float>(M_PI);
    CHECK(lamps[0].light.x() / (distance * distance) == Approx(1.4));
    CHECK(lamps[1].light.x() / (distance * distance) == Approx(1.4));
    CHECK(lamps[2].light.x() == Approx(1.4));
    CHECK(lamps[2].place.isApprox(Vec3f::UnitY()));
    // Illumination of a white surface = radiance times solid angle over pi, for a light that is small.
    CHECK(lamps[0].radiance.x() * 0.2f * 0.1f / (distance * distance) / pi == Approx(1.4));
    CHECK(lamps[1].radiance.x() * 0.01f * 0.01f / (distance * distance) == Approx(1.4));
    CHECK(lamps[2].radiance.x() * std::pow(std::sin(2 * pi / 180), 2.0f) == Approx(1.4));
    CHECK(lamps[0].axis.isApprox(Vec3f(0, -0.6f, -0.8f)));
    CHECK(4 * lamps[0].across.norm() * lamps[0].up.norm() == Approx(0.02));
    CHECK(std::abs(lamps[0].across.y()) < 1e-6f);
}

TEST_CASE("a soft box is mirrored in a smooth board where the law of reflection puts it, within a tenth of its size", "[render]") {
    const Light box = soft_box(Vec3f(0.05f, 0.3f, -0.3f), {0.16f, 0.08f});
    const Image image = board({box}, "dark", 0);
    const Lamp lamp = lamps_of({box})[0];
    int inside = 0, outside = 0, wrong = 0;
    for (int y = 0; y < height; y += 2)
        for (int x = 0; x < width; x += 2) {
            const Vec3f d = ray(x, y), q = view.position - view.position.y() / d.y() * d, r(d.x(), -d.y(), d.z());
            if (q.cwiseAbs().maxCoeff() > 0.29f) continue;
            const Vec3f off = q + (lamp.place - q).dot(lamp.axis) / r.dot(lamp.axis) * r - lamp.place;
            const float a = std::abs(off.dot(lamp.across)) / lamp.across.squaredNorm(),
                        b = std::abs(off.dot(lamp.up)) / lamp.up.squaredNorm();
            const float edge = std::max(a, b);
            if (std::abs(edge - 1) < 0.1f) continue;
            ++(edge < 1 ? inside : outside);
            wrong += (image.pixel(x, y)[0] > 150) != (edge < 1);
        }
    CHECK(inside > 100);
    CHECK(outside > 3000);
    CHECK(wrong == 0);
}

TEST_CASE("a lamp casts the shadow of a bar along the line from it, softer the larger it is, in its colour", "[render]") {
    // A long bar 0.08 m above the board; the lamp is 0.24 m above it, so that the shadow's middle is at 1.5 times the bar's x.
    Light lamp = soft_box(Vec3f(0, 0.24f, 0), {});
    lamp.kind = "lamp", lamp.colour = Colour(1, 0.5f, 0.25f);
    const FrameSolid bar = test::solid_of(test::box_mesh(Vec3f(0.05f, 0.075f, -0.2f), Vec3f(0.07f, 0.085f, 0.02f)), "dark");
    std::array<int, 2> partly{};
    for (const int large : {0, 1}) {
        lamp.radius = large != 0 ? 0.04f : 0.004f;
        const Image image = board({lamp}, "white", 1, {bar});
        const auto light_at = [&](float x) {
            const auto [column, row] = pixel_of(Vec3f(x, 0, -0.05f));
            return image.pixel(column, row);
        };
        const auto shaded = light_at(0.09f), lit = light_at(-0.09f), other = light_at(0.06f);
        INFO("radius " << lamp.radius << ": " << int(shaded[0]) << " " << int(lit[0]) << " " << int(other[0]));
        CHECK(shaded[0] < (large != 0 ? 0.75 : 0.3) * lit[0]);
        CHECK(other[0] > 0.7 * lit[0]);
        CHECK(lit[0] > lit[1] + 20);
        CHECK(lit[1] > lit[2] + 20);
        for (float x = 0.03f; x < 0.15f; x += 0.001f)
            if (const int v = light_at(x)[0]; v > 0.25 * lit[0] && v < 0.8 * lit[0]) ++partly[static_cast<std::size_t>(large)];
    }
    CHECK(partly[1] > 1.5 * partly[0]);
}

TEST_CASE("each of two lamps casts its shadow, and the other lights it in its colour", "[render]") {
    // The bar is 0.08 m above the board, the lamps are 0.24 m above it, 0.1 m to both sides: each shadow is 0.05 m beyond the bar.
    Light red = soft_box(Vec3f(-0.1f, 0.24f, 0), {}), blue = soft_box(Vec3f(0.1f, 0.24f, 0), {});
    red.kind = blue.kind = "lamp", red.radius = blue.radius = 0.004f;
    red.colour = Colour(1, 0.02f, 0.02f), blue.colour = Colour(0.02f, 0.02f, 1);
    const FrameSolid bar = test::solid_of(test::box_mesh(Vec3f(-0.01f, 0.075f, -0.2f), Vec3f(0.01f, 0.085f, 0.02f)), "dark");
    const Image image = board({red, blue}, "white", 1, {bar});
    const auto light_at = [&](float x) {
        const auto [column, row] = pixel_of(Vec3f(x, 0, -0.05f));
        return image.pixel(column, row);
    };
    const auto both = light_at(0.1f), only_blue = light_at(0.05f), only_red = light_at(-0.05f);
    INFO(int(both[0]) << " " << int(both[2]) << ", " << int(only_blue[0]) << " " << int(only_blue[2]) << ", " << int(only_red[0]) << " "
                      << int(only_red[2]));
    CHECK(only_blue[0] < 0.4 * both[0]);
    CHECK(only_blue[2] > 0.85 * both[2]);
    CHECK(only_red[2] < 0.4 * light_at(-0.1f)[2]);
    CHECK(only_red[0] > 0.85 * light_at(-0.1f)[0]);
}

TEST_CASE("the surround's strength scales the light, and its turn moves the shadow, unless they are 1 and 0", "[render]") {
    Frame frame;
    frame.spacing = 0.005f;
    frame.domain_min = Vec3f(-0.1f, 0, -0.1f), frame.domain_max = Vec3f(0.1f, 0.1f, 0.1f);
    frame.solids.push_back(test::solid_of(test::box_mesh(Vec3f(-0.02f, 0, -0.02f), Vec3f(0.02f, 0.08f, 0.02f)), "white"));
    LookOptions look;
    look.samples = 1;
    Renderer renderer(width, height);
    const Image usual = renderer.draw(frame, {}, look, view);
    look.surround_turn = 180;
    const Image turned = renderer.draw(frame, {}, look, view);
    // The shadow falls towards the viewer and to the right; turned, away from the viewer and to the left.
    const auto [x, y] = pixel_of(Vec3f(0.04f, 0, 0.045f));
    const auto [u, v] = pixel_of(Vec3f(-0.05f, 0, -0.05f));
    CHECK(usual.pixel(x, y)[0] + 15 < turned.pixel(x, y)[0]);
    CHECK(turned.pixel(u, v)[0] + 15 < usual.pixel(u, v)[0]);
    look.surround_turn = 0, look.surround_strength = 0.25f;
    const Image dim = renderer.draw(frame, {}, look, view);
    CHECK(dim.pixel(5, height - 5)[0] < 0.75 * usual.pixel(5, height - 5)[0]);
    look.surround_strength = 1;
    CHECK(renderer.draw(frame, {}, look, view).rgb == usual.rgb);
}

}  // namespace lights_test
