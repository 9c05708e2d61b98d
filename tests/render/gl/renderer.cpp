#include "render/gl/renderer.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <numbers>

#include "engine/core/errors.h"
#include "render/image/exr.h"
#include "render/image/image.h"
#include "tests/support/scratch.h"
#include "tests/support/shapes.h"

using namespace whorl;

namespace {

Frame empty_frame() {
    Frame frame;
    frame.spacing = 0.005f;
    frame.domain_min = Vec3f(-0.1f, 0, -0.1f);
    frame.domain_max = Vec3f(0.1f, 0.2f, 0.1f);
    return frame;
}

const View from_the_front{Vec3f(0, 0.1f, 0.6f), Vec3f(0, 0.1f, 0), Vec3f(0, 1, 0), 30};

LookOptions samples(int count) {
    LookOptions look;
    look.samples = count;
    return look;
}

/// One sample.
LookOptions in_style(const std::string& style) {
    LookOptions look = samples(1);
    look.style = style;
    return look;
}

FrameSolid solid(TriangleMesh mesh, const std::string& material = "white") { return test::solid_of(std::move(mesh), material); }

}  // namespace

TEST_CASE("an EGL device works, and the outcome of each tried device is reported", "[render]") {
    bool works = false;
    for (const DeviceAttempt& attempt : probe_devices()) {
        CHECK_FALSE(attempt.name.empty());
        CHECK_FALSE(attempt.outcome.empty());
        works = works || attempt.works;
    }
    CHECK(works);
}

TEST_CASE("a frame without fluid shows the studio, and two renderers can coexist", "[render]") {
    Renderer first(64, 48), second(32, 32);
    const Image studio = first.draw(empty_frame(), Surface{}, samples(1), from_the_front);
    CHECK(studio.rgb.size() == 3u * 64 * 48);
    CHECK(second.draw(empty_frame(), Surface{}, samples(1), from_the_front).width == 32);
    CHECK(first.draw(empty_frame(), Surface{}, samples(1), from_the_front).rgb == studio.rgb);
}

TEST_CASE("a mesh without a distance field is drawn, though opaque", "[render]") {
    Renderer renderer(64, 64);
    Surface ball = test::sphere(Vec3f(0, 0.1f, 0), 0.05f, 0.005f);
    ball.distance = Volume{};
    const Image picture = renderer.draw(empty_frame(), ball, samples(1), from_the_front);
    const auto* middle = picture.pixel(32, 32);
    CHECK(middle[0] > middle[2] + 60);
}

namespace {

float brightness(const Image& picture, int x, int y) {
    const auto* p = picture.pixel(x, y);
    return static_cast<float>(p[0] + p[1] + p[2]) / 3;
}

}  // namespace

TEST_CASE("a box darkens the plate at its foot and casts a soft shadow", "[render]") {
    Renderer renderer(192, 128);
    const View from_above{Vec3f(0, 0.35f, 0.5f), Vec3f(0, 0.02f, 0), Vec3f(0, 1, 0), 30};
    Frame frame = empty_frame();
    frame.solids.push_back(solid(test::box_mesh(Vec3f(-0.1f, 0, -0.1f), Vec3f(0.1f, 0.02f, 0.1f))));
    const Image alone = renderer.draw(frame, Surface{}, samples(1), from_above);
    frame.solids.push_back(solid(test::box_mesh(Vec3f(-0.02f, 0.02f, -0.02f), Vec3f(0.02f, 0.06f, 0.02f))));
    const Image both = renderer.draw(frame, Surface{}, samples(1), from_above);

    // The light is behind on the left: straight in front and on the right of the box there is shadow, far on the left nothing changes.
    int darkest_x = 0, darkest_y = 0;
    float most = 0;
    for (int y = 0; y < alone.height; ++y)
        for (int x = 0; x < alone.width; ++x)
            if (brightness(alone, x, y) - brightness(both, x, y) > most)
                most = brightness(alone, x, y) - brightness(both, x, y), darkest_x = x, darkest_y = y;
    CHECK(most > 40);
    CHECK(darkest_x > 80);
    CHECK(darkest_y > 50);
    CHECK(std::abs(brightness(alone, 50, 70) - brightness(both, 50, 70)) < 4);
    // A solid does not shade itself: the top of a lone plate varies only by reflections of the studio.
    CHECK(std::abs(brightness(alone, 96, 70) - brightness(alone, 110, 70)) < 6);
}

TEST_CASE("with a fixed range a speed has the same colour whatever other particles do", "[render]") {
    Renderer renderer(96, 64);
    Frame frame = empty_frame();
    frame.spacing = 0.06f;
    frame.position = {Vec3f(-0.06f, 0.1f, 0), Vec3f(0.06f, 0.1f, 0)};
    frame.velocity = {Vec3f(1, 0, 0), Vec3f(1, 0, 0)};
    LookOptions look = in_style("particles");
    look.range = {0, 4};
    const Image slow = renderer.draw(frame, Surface{}, look, from_the_front);
    frame.velocity[1] = Vec3f(4, 0, 0);
    const Image fast = renderer.draw(frame, Surface{}, look, from_the_front);
    bool other_changed = false;
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 96; ++x) {
            if (x < 40) REQUIRE(std::equal(slow.pixel(x, y), slow.pixel(x, y) + 3, fast.pixel(x, y)));
            other_changed = other_changed || slow.pixel(x, y)[0] != fast.pixel(x, y)[0];
        }
    CHECK(other_changed);
}

namespace {

/// A ball of fluid that rotates about z, faster outside.
Frame turning_ball() {
    Frame frame = empty_frame();
    frame.spacing = 0.01f;
    for (float x = -0.1f; x <= 0.1f; x += 0.01f)
        for (float y = 0; y <= 0.2f; y += 0.01f)
            for (float z = -0.1f; z <= 0.1f; z += 0.01f) {
                if (Vec3f(x, y - 0.1f, z).norm() > 0.1f) continue;
                frame.position.emplace_back(x, y, z);
                frame.velocity.emplace_back(-(y - 0.1f), x, 0);
            }
    return frame;
}

}  // namespace

TEST_CASE("a slice shows the field in its plane: dark in the middle of a turning ball, bright at its rim", "[render]") {
    Renderer renderer(160, 120);
    LookOptions look = in_style("slice");
    look.streaks = false;
    const Image picture = renderer.draw(turning_ball(), Surface{}, look, from_the_front);
    const int rim = 80 + static_cast<int>(0.085 / 0.6 * 120 / (2 * 0.26795));
    const auto *middle = picture.pixel(80, 60), *outer = picture.pixel(rim, 60);
    CHECK(outer[1] > middle[1] + 80);
    CHECK(middle[2] > middle[1] + 20);
}

TEST_CASE("a volume is a cloud: objects show through its thin parts, and strong parts glow", "[render]") {
    Renderer renderer(160, 120);
    LookOptions look = in_style("volume");
    look.colour_map = "inferno";
    look.opacity = 3;
    const Image nothing = renderer.draw(empty_frame(), Surface{}, look, from_the_front);
    const Image cloud = renderer.draw(turning_ball(), Surface{}, look, from_the_front);
    const int rim = 80 + static_cast<int>(0.085 / 0.6 * 120 / (2 * 0.26795));
    // The axis is at rest, so the studio shows through it. The rim is fast.
    CHECK(std::abs(brightness(cloud, 80, 60) - brightness(nothing, 80, 60)) < 40);
    CHECK(cloud.pixel(rim, 60)[0] > cloud.pixel(rim, 60)[2] + 60);
}

TEST_CASE("trails draw where a particle came from", "[render]") {
    Renderer renderer(160, 120);
    LookOptions look = in_style("particles");
    const Image without = renderer.draw(turning_ball(), Surface{}, look, from_the_front);
    look.trail = 0.3f;
    const Image with = renderer.draw(turning_ball(), Surface{}, look, from_the_front);
    CHECK(difference(with, without).mean > 0.5);
}

namespace {

/// Differences of brightness between neighbouring pixels of the middle row.
int sharpest_step(const Image& picture) {
    int most = 0;
    for (int x = 1; x < picture.width; ++x)
        most = std::max(most, std::abs(int(picture.pixel(x, picture.height / 2)[1]) - int(picture.pixel(x - 1, picture.height / 2)[1])));
    return most;
}

Frame with_dark_post(float z) {
    Frame frame = empty_frame();
    frame.solids.push_back(solid(test::box_mesh(Vec3f(-0.02f, 0, z - 0.005f), Vec3f(0.02f, 0.2f, z + 0.005f)), "dark"));
    return frame;
}

}  // namespace

TEST_CASE("a wide lens is as sharp as a pinhole at its focus, and blurs objects behind it", "[render]") {
    Renderer renderer(160, 96);
    const LookOptions look = samples(32);
    View lens = from_the_front;
    lens.aperture = 0.06f;
    lens.focus = 0.6f;
    const int sharp = sharpest_step(renderer.draw(with_dark_post(0), Surface{}, look, from_the_front));
    CHECK(sharpest_step(renderer.draw(with_dark_post(0), Surface{}, look, lens)) > 0.8 * sharp);
    CHECK(sharpest_step(renderer.draw(with_dark_post(-0.3f), Surface{}, look, from_the_front)) > 0.7 * sharp);
    CHECK(sharpest_step(renderer.draw(with_dark_post(-0.3f), Surface{}, look, lens)) < 0.5 * sharp);
}

TEST_CASE("an open shutter blurs a moving solid, and not a fixed one", "[render]") {
    Renderer renderer(160, 96);
    const LookOptions look = samples(32);
    View open = from_the_front;
    open.open = 0.02f;
    Frame frame = with_dark_post(0);
    const int sharp = sharpest_step(renderer.draw(frame, Surface{}, look, from_the_front));
    CHECK(sharpest_step(renderer.draw(frame, Surface{}, look, open)) > 0.9 * sharp);
    frame.solids[0].velocity = Vec3f(1, 0, 0);  // by half its width
    CHECK(sharpest_step(renderer.draw(frame, Surface{}, look, open)) < 0.5 * sharp);
    frame.solids[0].velocity = Vec3f::Zero();
    frame.solids[0].spin = Vec3f(0, 100, 0);  // by two radians about its own axis
    CHECK(sharpest_step(renderer.draw(frame, Surface{}, look, open)) < 0.8 * sharp);
}

TEST_CASE("an open shutter smears a surface by the velocity at its vertices", "[render]") {
    Renderer renderer(160, 96);
    LookOptions look = samples(16);
    look.style = "opaque";
    look.colour = Vec3f::Constant(0.01f);
    View open = from_the_front;
    open.open = 0.02f;
    Surface ball = test::sphere(Vec3f(0, 0.1f, 0), 0.04f, 0.004f);
    const int sharp = sharpest_step(renderer.draw(empty_frame(), ball, look, open));
    ball.velocity.assign(ball.mesh.position.size(), Vec3f(2, 0, 0));
    CHECK(sharpest_step(renderer.draw(empty_frame(), ball, look, open)) < 0.6 * sharp);
}

TEST_CASE("a look with a missing image file is refused", "[render]") {
    Renderer renderer(32, 32);
    LookOptions look = samples(1);
    look.environment = "/no/such/picture.exr";
    CHECK_THROWS_AS(renderer.draw(empty_frame(), Surface{}, look, from_the_front), InputError);
}

TEST_CASE("an environment image is visible behind the scene, its upper half above", "[render]") {
    const test::ScratchFolder folder;
    PictureLayers sky{4, 2};  // green above, red below
    for (int k = 0; k < 8; ++k)
        for (const float light : {k < 4 ? 0.25f : 1.0f, k < 4 ? 1.0f : 0.25f, 0.25f, 1.0f}) sky.light.push_back(light);
    write_exr(folder / "sky.exr", sky, {});
    LookOptions look = samples(1);
    look.environment = folder / "sky.exr";
    Renderer renderer(96, 64);
    const Image picture = renderer.draw(empty_frame(), test::sphere(Vec3f(0, 0.1f, 0), 0.05f, 0.004f), look, from_the_front);
    CHECK(picture.pixel(4, 8)[1] > picture.pixel(4, 8)[0] + 20);
}

// A lens of zero width does not blur, but makes every pixel use all samples. A delta E of 2.3 is a just noticeable difference. Half floats
// round a backdrop that is a sum of samples by .1 on average.
TEST_CASE("pixels that stop at their first sample look as with all samples, on honey, glass and wood", "[render]") {
    Renderer renderer(320, 240);
    Frame frame = empty_frame();
    frame.solids = {solid(test::box_mesh(Vec3f(-0.09f, 0, -0.09f), Vec3f(0.09f, 0.15f, 0.09f)), "glass"),
                    solid(test::sphere(Vec3f(-0.05f, 0.03f, 0.05f), 0.028f, 0.002f).mesh, "wood")};
    frame.solids[0].container = true;
    const Surface honey = test::coiled_thread(0.008f, 0.03f, 3, 0.12f, 0.002f);
    const LookOptions look = samples(8);
    View all = from_the_front;
    all.aperture = 1e-12f, all.focus = 0.6f;
    const PictureDifference d = difference(renderer.draw(frame, honey, look, from_the_front), renderer.draw(frame, honey, look, all));
    INFO("mean " << d.mean << ", 99th percentile " << d.p99);
    CHECK(d.mean < 0.2);
    CHECK(d.p99 < 1.5);
}

TEST_CASE("a nozzle is not visible through the honey below it", "[render]") {
    Renderer renderer(480, 320);
    const Surface thread =
        test::surface_of([](const Vec3f& x) { return std::max(std::hypot(x.x(), x.z()) - 0.02f, std::abs(x.y() - 0.1f) - 0.1f); },
                         Vec3f(-0.02f, 0, -0.02f), Vec3f(0.02f, 0.2f, 0.02f), 0.004f);
    const View from_above{Vec3f(0, 0.25f, 0.6f), Vec3f(0, 0.1f, 0), Vec3f(0, 1, 0), 30};
    Frame frame = empty_frame();
    // Both images have a small solid far away, so that both are drawn by the same path.
    frame.solids.push_back(solid(test::box_mesh(Vec3f(0.09f, 0, -0.1f), Vec3f(0.1f, 0.01f, -0.09f))));
    const Image without = renderer.draw(frame, thread, samples(1), from_above);
    frame.solids.push_back(solid(test::box_mesh(Vec3f(-0.03f, 0.12f, -0.03f), Vec3f(0.03f, 0.2f, 0.03f)), "dark"));
    const Image with = renderer.draw(frame, thread, samples(1), from_above);
    // The lowest row of the nozzle, next to the thread (column 214; the thread: 219 to 261), and a row for its soft edge.
    int below = 0;
    for (int y = 75; y < 200; ++y)
        if (brightness(with, 214, y) < brightness(without, 214, y) - 40) below = y + 2;
    REQUIRE(below > 100);
    REQUIRE(below < 180);
    for (int y = below; y < below + 40; ++y) {
        INFO("row " << y);
        CHECK(std::abs(brightness(with, 240, y) - brightness(without, 240, y)) < 6);  // its shadow on the ground is seen, too
    }
}

TEST_CASE("a post in clear fluid is seen at the position that refraction predicts", "[render]") {
    constexpr float half = 0.08f, x = 0.06f, face = -0.06f, index = 2;
    Renderer renderer(320, 240);
    const Surface block = test::surface_of([&](const Vec3f& p) { return (p - Vec3f(0, half, 0)).cwiseAbs().maxCoeff() - half; },
                                           Vec3f(-half, 0, -half), Vec3f(half, 2 * half, half), 0.004f);
    Frame frame = empty_frame();
    frame.solids.push_back(solid(test::box_mesh(Vec3f(x - 0.005f, 0.01f, face - 0.01f), Vec3f(x + 0.005f, 0.15f, face)), "dark"));
    LookOptions look = samples(1);
    look.material = "water", look.refraction = index;
    const Image picture = renderer.draw(frame, block, look, {Vec3f(0, half, 0.6f), Vec3f(0, half, 0), Vec3f(0, 1, 0), 30});
    // Snell: tan of the angle before the block's face, by bisection.
    float low = 0, high = 1;
    for (int k = 0; k < 40; ++k) {
        const float t = (low + high) / 2, bent = t / std::sqrt(1 + t * t) / index,
                    reached = (0.6f - half) * t + (half - face) * bent / std::sqrt(1 - bent * bent);
        (reached < x ? low : high) = t;
    }
    const float pixel = 120 / std::tan(15 * 3.14159265f / 180), expected = 160 + pixel * low, straight = 160 + pixel * x / (0.6f - face);
    REQUIRE(expected > straight + 4);
    float darkest = 255, sum = 0;
    int dark = 0;
    for (int k = 160; k < 240; ++k) darkest = std::min(darkest, brightness(picture, k, 120));
    for (int k = 160; k < 240; ++k)
        if (brightness(picture, k, 120) < darkest + 20) sum += static_cast<float>(k) + 0.5f, ++dark;
    INFO("seen at " << sum / static_cast<float>(dark) << ", expected at " << expected << ", without refraction at " << straight);
    CHECK(std::abs(sum / static_cast<float>(dark) - expected) < 2);  // half a voxel of the solids' field, and half a pixel
}

TEST_CASE("earlier images of a renderer do not change the next one, whatever it caches", "[render]") {
    struct Scene {
        Frame frame = empty_frame();
        LookOptions look = {};
        View view = from_the_front;
    } start;
    start.frame.solids = {solid(test::box_mesh(Vec3f(-0.08f, 0, -0.08f), Vec3f(0.08f, 0.02f, 0.08f))),
                          solid(test::box_mesh(Vec3f(-0.02f, 0, -0.02f), Vec3f(0.02f, 0.06f, 0.02f)))};
    start.frame.solids[1].translation = Vec3f(0.04f, 0.02f, 0);
    const Surface ball = test::sphere(Vec3f(-0.03f, 0.06f, 0), 0.03f, 0.005f);
    // Each changes one input of a cached value.
    const std::vector<std::pair<const char*, void (*)(Scene&)>> changes{
        {"the camera moves", [](Scene& s) { s.view.position += Vec3f(0.1f, 0.05f, 0); }},
        {"the camera looks elsewhere", [](Scene& s) { s.view.target += Vec3f(0.02f, 0, 0); }},
        {"the camera zooms", [](Scene& s) { s.view.fov = 24; }},
        {"the camera rolls", [](Scene& s) { s.view.up = Vec3f(0.2f, 1, 0).normalized(); }},
        {"another background", [](Scene& s) { s.look.background = "dark"; }},
        {"another table", [](Scene& s) { s.look.table = "wood"; }},
        {"no ground", [](Scene& s) { s.look.ground = false; }},
        {"the ground sinks", [](Scene& s) { s.frame.domain_min.y() = -0.02f; }},
        {"a lone solid moves", [](Scene& s) { s.frame.solids[1].translation += Vec3f(0, 0.03f, 0); }},
        {"all solids turn together",
         [](Scene& s) {
             const Mat3f turn = Eigen::AngleAxisf(0.7f, Vec3f::UnitY()).toRotationMatrix();
             for (FrameSolid& one : s.frame.solids)
                 one.rotation = turn * one.rotation, one.translation = turn * one.translation + Vec3f(0, 0.01f, 0);
         }},
        {"a solid is of another material", [](Scene& s) { s.frame.solids[0].appearance.material = "wood"; }},
        {"a solid is of another colour",
         [](Scene& s) {
             s.frame.solids[0].appearance.colour = {0.6f, 0.1f, 0.1f};
         }},
        {"a solid is rougher", [](Scene& s) { s.frame.solids[0].appearance.roughness = 0.9f; }},
        {"a solid less", [](Scene& s) { s.frame.solids.pop_back(); }},
        {"words in the picture", [](Scene& s) {
             s.look.style = "particles", s.look.legend = true, s.frame.position = {Vec3f(0, 0.1f, 0)}, s.frame.velocity = {Vec3f::UnitX()};
         }}};
    const auto drawn = [&](Renderer& by, const Scene& s) { return by.draw(s.frame, ball, s.look, s.view).rgb; };
    Renderer used(96, 64);
    for (const auto& [name, change] : changes) {
        Renderer fresh(96, 64);  // draws only the changed scene
        for (const int samples : {1, 4}) {
            INFO(name << ", " << samples << " samples");
            start.look.samples = samples;
            Scene changed = start;
            change(changed);
            const auto before = drawn(used, start), picture = drawn(fresh, changed);
            CHECK((picture != before));
            // Bit-identical, so that a resumed run equals an uninterrupted one.
            CHECK((drawn(used, changed) == picture));
            if (samples > 1) CHECK((drawn(fresh, changed) == picture));
        }
    }
}

TEST_CASE("a thin plate by its pose is drawn as by its corners", "[render]") {
    Renderer renderer(160, 120);
    FrameSolid posed = solid(test::box_mesh(Vec3f(0.01f, 0, 0), Vec3f(0.07f, 0.08f, 0.002f))), placed = posed;
    posed.rotation = Eigen::AngleAxisf(std::numbers::pi_v<float> / 2, Vec3f::UnitY()).toRotationMatrix();
    posed.translation = Vec3f(0.04f, 0, 0.08f);
    auto mesh = std::make_shared<TriangleMesh>(*posed.mesh);
    for (Vec3f& x : mesh->position) x = posed.rotation * x + posed.translation;
    for (Vec3f& n : mesh->normal) n = posed.rotation * n;
    placed.mesh = mesh;
    Frame frame = empty_frame();
    const View from_above{Vec3f(0.2f, 0.35f, 0.5f), Vec3f(0, 0.03f, 0), Vec3f(0, 1, 0), 22};
    frame.solids = {solid(test::box_mesh(Vec3f(0.05f, 0, 0.01f), Vec3f(0.09f, 0.04f, 0.05f))), posed};
    const Image by_pose = renderer.draw(frame, Surface{}, samples(1), from_above);
    frame.solids[1] = placed;
    const Image by_corners = renderer.draw(frame, Surface{}, samples(1), from_above);
    CHECK(difference(by_pose, by_corners).max < 1);  // the fields differ by rounding
}

TEST_CASE("a particle is a whole disc from any side", "[render]") {
    Renderer renderer(64, 64);
    LookOptions look = in_style("particles");
    look.ground = false;
    const Vec3f middle(0, 0.1f, 0);
    const auto drawn = [&](const View& view, bool any) {
        Frame frame = empty_frame();
        frame.spacing = 0.1f;
        if (any) frame.position = {middle}, frame.velocity = {Vec3f(1, 0, 0)};
        return renderer.draw(frame, Surface{}, look, view);
    };
    for (const Vec3f& way : {Vec3f(1, 0, 0), Vec3f(-1, 0, 0), Vec3f(0, 1, 0), Vec3f(0, -1, 0), Vec3f(0, 0, 1), Vec3f(0, 0, -1)}) {
        const View view{middle + 0.6f * way, middle, way.y() == 0 ? Vec3f(0, 1, 0) : Vec3f(0, 0, 1), 15};
        const Image with = drawn(view, true), without = drawn(view, false);
        int changed = 0;
        for (int y = 0; y < 64; ++y)
            for (int x = 0; x < 64; ++x)
                changed += with.pixel(x, y)[0] != without.pixel(x, y)[0] || with.pixel(x, y)[2] != without.pixel(x, y)[2];
        const double radius = 0.05 / 0.6 * 32 / std::tan(7.5 * std::numbers::pi / 180);  // px
        CHECK(changed == Approx(std::numbers::pi * radius * radius).epsilon(0.1));
    }
}

TEST_CASE("paint with inks of no concentration looks like paint without inks", "[render]") {
    Renderer renderer(48, 48);
    Frame frame = empty_frame();
    for (int i = -6; i <= 6; ++i)
        for (int j = -6; j <= 6; ++j)
            for (int k = -6; k <= 6; ++k)
                frame.position.push_back(Vec3f(0, 0.1f, 0) +
                                         0.01f * Vec3f(static_cast<float>(i), static_cast<float>(j), static_cast<float>(k)));
    frame.velocity.assign(frame.position.size(), Vec3f::Zero());
    frame.spacing = 0.01f;
    LookOptions look = samples(1);
    look.material = "paint";
    const Surface ball = test::sphere(Vec3f(0, 0.1f, 0), 0.05f, 0.005f);
    const Image plain = renderer.draw(frame, ball, look, from_the_front);
    frame.vector["ink"].assign(frame.position.size(), Vec3f::Zero());
    CHECK(difference(renderer.draw(frame, ball, look, from_the_front), plain).max < 2);
}
