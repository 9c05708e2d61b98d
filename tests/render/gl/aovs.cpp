/// Images for compositing: depth, motion and transparency.
#include <catch2/catch.hpp>
#include <cmath>

#include "render/gl/renderer.h"
#include "tests/support/shapes.h"

using namespace whorl;

namespace gl_layers_test {

namespace {

constexpr int width = 160, height = 120;
constexpr float tan_half = 0.26794919f;  // tangent of 15 degrees, half of the view's angle
constexpr float pixels_a_metre_at_1 = height / 2 / tan_half;

const View ahead{Vec3f(0, 0.1f, 0.6f), Vec3f(0, 0.1f, 0), Vec3f(0, 1, 0), 30};

/// A white ball of radius 4 cm in the middle of the image, unoccluded.
Frame ball() {
    Frame frame;
    frame.spacing = 0.005f;
    frame.domain_min = Vec3f(-0.1f, 0, -0.1f), frame.domain_max = Vec3f(0.1f, 0.2f, 0.1f);
    frame.solids = {test::solid_of(test::sphere(Vec3f::Zero(), 0.04f, 0.002f).mesh, "white")};
    frame.solids[0].translation = Vec3f(0, 0.1f, 0);
    return frame;
}

LookOptions transparent() {
    LookOptions look;
    look.background = "transparent";
    return look;
}

struct Seen {
    float depth;
    Vec3f normal;
    Eigen::Vector2f motion;
    std::uint32_t id;
    float alpha;
};
Seen at(const PictureLayers& layers, int x, int y) {
    const std::size_t i = grid_index(x, y, layers.width);
    return {layers.depth[i], Vec3f(layers.normal[3 * i], layers.normal[3 * i + 1], layers.normal[3 * i + 2]),
            Eigen::Vector2f(layers.motion[2 * i], layers.motion[2 * i + 1]), layers.id[i], layers.light[4 * i + 3]};
}

}  // namespace

TEST_CASE("depth is along the view axis, normals are in world space, and ids count from the fluid on", "[render][exr]") {
    Renderer renderer(width, height);
    Frame frame = ball();
    frame.solids.push_back(test::solid_of(test::box_mesh(Vec3f(-1, -1, -0.31f), Vec3f(1, 1, -0.3f))));
    const PictureLayers layers = renderer.draw_layers(frame, test::sphere(Vec3f(0.08f, 0.1f, 0), 0.02f, 0.002f), {}, ahead, {ahead, 0.04f});
    const Seen middle = at(layers, width / 2, height / 2);
    // The ball's front is 0.56 m ahead; a pixel off its middle is 2e-5 m deeper, and its mesh lies 1e-4 m inside it.
    CHECK(middle.depth == Approx(0.56).margin(2e-4));
    CHECK((middle.normal - Vec3f::UnitZ()).norm() < 0.06f);
    CHECK(middle.id == 2);
    // A plane across the view has one depth up to the corners, where it is 4 % further away along the ray.
    for (const auto& [x, y] : {std::pair{2, 2}, {80, 2}, {157, 40}}) {
        const Seen behind = at(layers, x, y);
        CHECK(behind.depth == Approx(0.9).margin(1e-4));
        CHECK((behind.normal - Vec3f::UnitZ()).norm() < 1e-3f);
        CHECK(behind.id == 3);
    }
    CHECK(at(layers, width / 2 + static_cast<int>(0.08f / 0.6f * pixels_a_metre_at_1), height / 2).id == 1);
}

TEST_CASE("motion of solids, fluid and camera is in pixels right and up until the next frame", "[render][exr]") {
    Renderer renderer(width, height);
    Frame frame = ball();
    Surface drop = test::sphere(Vec3f(0.08f, 0.1f, 0), 0.02f, 0.002f);
    drop.velocity.assign(drop.mesh.position.size(), Vec3f(0, -0.5f, 0));
    const float interval = 0.04f;
    const int of_drop = width / 2 + static_cast<int>(0.08f / 0.58f * pixels_a_metre_at_1);
    frame.solids[0].velocity = Vec3f(0.25f, 0.5f, 0);
    const PictureLayers moved = renderer.draw_layers(frame, drop, {}, ahead, {ahead, interval});
    // The ball's front is at 0.56 m, the drop's at 0.58 m; half floats resolve a hundredth of a pixel here.
    const float of_ball = interval * pixels_a_metre_at_1 / 0.56f, of_fluid = interval * pixels_a_metre_at_1 / 0.58f;
    CHECK((at(moved, width / 2, height / 2).motion - of_ball * Eigen::Vector2f(0.25f, 0.5f)).norm() < 0.02f);
    CHECK((at(moved, of_drop, height / 2).motion - of_fluid * Eigen::Vector2f(0, -0.5f)).norm() < 0.02f);
    CHECK(at(moved, 3, 3).motion.norm() < 0.02f);

    // A quarter turn about the view axis moves a point 10.5 pixels right of the centre, and half of one below, above it.
    frame.solids[0].velocity = Vec3f::Zero();
    frame.solids[0].spin = Vec3f(0, 0, 1.5707963f / interval);
    const PictureLayers turned = renderer.draw_layers(frame, Surface{}, {}, ahead, {ahead, interval});
    CHECK((at(turned, width / 2 + 10, height / 2).motion - Eigen::Vector2f(-10, 11)).norm() < 0.05f);

    // The camera moves right by 1 cm: everything moves left, near objects farther.
    View aside = ahead;
    aside.position.x() += 0.01f, aside.target.x() += 0.01f;
    const PictureLayers passed = renderer.draw_layers(ball(), Surface{}, {}, ahead, {aside, interval});
    CHECK(at(passed, width / 2, height / 2).motion.x() == Approx(-0.01f * pixels_a_metre_at_1 / 0.56f).margin(0.02));
    const Seen ground = at(passed, width / 2, height - 3);
    CHECK(ground.id == 0);
    CHECK(ground.depth < 1);
    CHECK(ground.motion.x() == Approx(-0.01f * pixels_a_metre_at_1 / ground.depth).margin(0.02));
}

TEST_CASE("a transparent image has alpha 1 in a solid and 0 beyond, and only the ground's shadow", "[render][exr]") {
    Renderer renderer(width, height);
    View from_above = ahead;
    from_above.position = Vec3f(0, 0.4f, 0.5f), from_above.target = Vec3f(0, 0.05f, 0);
    Frame frame = ball();
    frame.solids[0].translation.y() = 0.045f;
    const PictureLayers layers = renderer.draw_layers(frame, Surface{}, transparent(), from_above, {from_above, 0.04f});
    const Seen middle = at(layers, width / 2, height / 2), corner = at(layers, 2, 2);
    CHECK(middle.alpha == 1);
    CHECK((corner.alpha == 0 && corner.depth == nothing_there && corner.id == 0));
    // The lamp is behind: the shadow falls towards the viewer and removes more than a third of the light on the ground.
    float darkest = 1;
    for (int y = height / 2; y < height; ++y) {
        const std::size_t i = grid_index(width / 2, y, width);
        if (layers.light[4 * i + 3] == 0) darkest = std::min(darkest, layers.shadow[3 * i]);
    }
    CHECK(darkest < 0.65f);
    CHECK(layers.shadow[0] > 0.97f);
    LookOptions no_ground = transparent();
    no_ground.ground = false;
    const PictureLayers alone = renderer.draw_layers(frame, Surface{}, no_ground, from_above, {from_above, 0.04f});
    CHECK(*std::min_element(alone.shadow.begin(), alone.shadow.end()) == 1);

    const Image picture = renderer.draw(frame, Surface{}, transparent(), from_above);
    CHECK(picture.alpha[grid_index(width / 2, height / 2, width)] == 255);
    CHECK(picture.alpha[0] < 4);
    CHECK(*std::max_element(picture.alpha.begin(), picture.alpha.end() - 40 * width) == 255);

    // Light through honey falls on the ground in its colour.
    frame.solids.clear();
    const Surface drop = test::sphere(Vec3f(0, 0.022f, 0), 0.02f, 0.001f);
    const PictureLayers honey = renderer.draw_layers(frame, drop, transparent(), from_above, {from_above, 0.04f});
    float reddest = 0;
    for (std::size_t i = 0; i < honey.shadow.size(); i += 3) reddest = std::max(reddest, honey.shadow[i] - honey.shadow[i + 2]);
    CHECK(reddest > 0.1f);
}

TEST_CASE("a transparent image over its plate, or honey over the studio, equals the opaque image", "[render][exr]") {
    Renderer renderer(width, height);
    const Frame frame = ball();
    const Image opaque = renderer.draw(frame, Surface{}, {}, ahead),
                over = over_grey(renderer.draw(frame, Surface{}, transparent(), ahead));
    // Within a tenth of the picture's height of the middle the lens darkens the opaque picture by 0.4 %, a value of 255; and both dither.
    int most = 0;
    for (int y = height / 2 - 8; y <= height / 2 + 8; ++y)
        for (int x = width / 2 - 8; x <= width / 2 + 8; ++x)
            for (int c = 0; c < 3; ++c) most = std::max(most, std::abs(opaque.pixel(x, y)[c] - over.pixel(x, y)[c]));
    CHECK(most <= 2);

    // Translucent things: light + (1 - alpha) backdrop is the opaque image's light, with the studio's backdrop
    // behind.
    Frame empty = ball();
    empty.solids.clear();
    for (const char* material : {"honey", "water"}) {
        LookOptions clear = transparent(), studio;
        clear.material = studio.material = material;
        clear.ground = studio.ground = false;
        // A pane across the view, which deflects no ray.
        const auto pane = [](const Vec3f& x) { return ((x - Vec3f(0, 0.1f, 0)).cwiseAbs() - Vec3f(0.02f, 0.02f, 0.0015f)).maxCoeff(); };
        const Surface drop = test::surface_of(pane, Vec3f(-0.025f, 0.075f, -0.005f), Vec3f(0.025f, 0.125f, 0.005f), 0.0005f);
        const PictureLayers laid = renderer.draw_layers(empty, drop, clear, ahead, {ahead, 0}),
                            whole = renderer.draw_layers(empty, drop, studio, ahead, {ahead, 0}),
                            backdrop = renderer.draw_layers(empty, Surface{}, studio, ahead, {ahead, 0});
        const std::size_t middle = 4 * grid_index(width / 2, height / 2, width);
        INFO(material << " has alpha " << laid.light[middle + 3]);
        CHECK(laid.light[middle + 3] > 0.01f);
        CHECK(laid.light[middle + 3] < 0.95f);
        // Half floats resolve 1/2000.
        for (std::size_t c = 0; c < 3; ++c)
            CHECK(laid.light[middle + c] + (1 - laid.light[middle + 3]) * backdrop.light[middle + c] ==
                  Approx(whole.light[middle + c]).epsilon(0.005));
    }
}

TEST_CASE("the light of an opaque image, converted for screens, equals the image", "[render][exr]") {
    Renderer renderer(width, height);
    const Surface drop = test::sphere(Vec3f(0.03f, 0.1f, 0.05f), 0.03f, 0.002f);
    const Image picture = renderer.draw(ball(), drop, {}, ahead), made = shown(renderer.draw_layers(ball(), drop, {}, ahead, {ahead, 0}));
    CHECK(made.alpha.empty());
    // Light is stored as half floats, with a resolution of 1/2000: finer than a step of 8 bits.
    int most = 0;
    for (std::size_t i = 0; i < picture.rgb.size(); ++i) most = std::max(most, std::abs(picture.rgb[i] - made.rgb[i]));
    CHECK(most <= 1);
}

}  // namespace gl_layers_test
