#include "render/look/camera.h"

#include <catch2/catch.hpp>

#include "render/look/look_options.h"

using namespace whorl;

namespace {
const Vec3f low(-0.1f, 0, -0.1f), high(0.1f, 0.2f, 0.1f);
}

TEST_CASE("a camera on keys passes through each key, and continuously between them", "[render]") {
    CameraOptions camera;
    camera.kind = "keys";
    for (int i = 0; i < 4; ++i) camera.keys.push_back({0.5 * i * i, Vec3f(float(i), 0, 1), Vec3f::Zero(), 30.0f + float(i)});
    for (const CameraKey& key : camera.keys) CHECK((view_at(camera, key.time, low, high).position - key.position).norm() < 1e-5f);
    Vec3f last = view_at(camera, 0, low, high).position;
    for (double t = 0; t < 5; t += 0.01) {
        const Vec3f now = view_at(camera, t, low, high).position;
        CHECK((now - last).norm() < 0.04f);  // the fastest span covers 1 in 0.5 s
        last = now;
    }
}

TEST_CASE("a camera rests between equal keys, overshoots none, and passes through keys on its way", "[render]") {
    CameraOptions camera;
    camera.kind = "keys";
    const auto key = [&](double time, float z, float fov) { camera.keys.push_back({time, Vec3f(0, 0, z), Vec3f::Zero(), fov}); };
    const auto z_at = [&](double time) { return view_at(camera, time, low, high).position.z(); };
    SECTION("it comes near and waits") {
        key(0, 6, 60), key(0.25, 1, 5), key(2, 1, 5);
        for (double t = 0, last = 6; t < 2.1; t += 0.01) {
            const View view = view_at(camera, t, low, high);
            CHECK(view.position.z() <= last);
            last = static_cast<double>(view.position.z());
            REQUIRE(view.fov >= 5);
            REQUIRE(view.position.z() >= 1);
            if (t >= 0.25) REQUIRE((view.fov == 5 && view.position.z() == 1));
        }
    }
    SECTION("it turns round in a key") {
        key(0, 1, 30), key(1, 2, 30), key(3, 1.5f, 30), key(3.1, 9, 30);
        for (double t = 0; t < 3; t += 0.01) REQUIRE(z_at(t) <= 2);
        for (double t = 1; t < 3.1; t += 0.01) REQUIRE(z_at(t) >= 1.5f);
    }
    SECTION("it sweeps") {
        key(0, 0, 30), key(1, 1, 30), key(2, 3, 30), key(3, 4, 30);
        for (const double time : {1.0, 2.0}) {
            const double before = static_cast<double>(z_at(time) - z_at(time - 0.001)),
                         after = static_cast<double>(z_at(time + 0.001) - z_at(time));
            CHECK(before == Approx(1.5e-3).epsilon(0.02));
            CHECK(after == Approx(before).epsilon(0.02));
        }
    }
    SECTION("it cuts from one place to another") {
        key(0, 0, 30), key(1, 1, 30), key(1, 50, 30), key(2, 51, 30);
        CHECK(z_at(0.5) == Approx(0.5));
        CHECK(z_at(1.5) == Approx(50.5));
    }
}

TEST_CASE("an orbit keeps its distance and completes a turn", "[render]") {
    CameraOptions camera;
    camera.kind = "orbit";
    camera.degrees_per_second = 90;
    const Vec3f start = view_at(camera, 0, low, high).position, quarter = view_at(camera, 1, low, high).position;
    CHECK((view_at(camera, 4, low, high).position - start).norm() < 1e-5f);
    CHECK((quarter - Vec3f(camera.distance, camera.height, 0)).norm() < 1e-5f);
}

TEST_CASE("the camera that frames the domain does not move while the fluid does", "[render]") {
    const View first = view_at({}, 0, low, high), later = view_at({}, 7, low, high);
    CHECK(first.position == later.position);
    CHECK((first.target - first.position).norm() > 0.3f);
}

TEST_CASE("an automatic camera shows its whole box, as near as the image's sides allow", "[render]") {
    CameraOptions camera;
    camera.aspect = GENERATE(16.0f / 9, 1.0f, 0.5f);
    const Vec3f size = GENERATE(Vec3f(1, 1, 1), Vec3f(0.1f, 3, 0.1f), Vec3f(4, 0.1f, 1), Vec3f(0.1f, 0.1f, 5), Vec3f(2, 1, 0));
    const Vec3f from(0.3f, -2, 0.7f);
    const bool plane = size.z() == 0;
    camera.min = from, camera.max = from + size;
    const View view = view_at(camera, 0, Vec3f(-50, -50, plane ? 0 : -50), Vec3f(50, 50, plane ? 0 : 50));
    const Vec3f ahead = (view.target - view.position).normalized(), side = ahead.cross(view.up).normalized(), above = side.cross(ahead);
    float h = 0, v = 0;  // the furthest corner, 1 at the picture's edge
    for (int corner = 0; corner < 8; ++corner) {
        const Vec3f way(corner & 1 ? size.x() : 0, corner & 2 ? size.y() : 0, corner & 4 ? size.z() : 0), x = from + way - view.position;
        const float half = x.dot(ahead) * std::tan(15 * 3.14159265f / 180);
        REQUIRE(half > 0);
        h = std::max(h, std::abs(x.dot(side)) / (half * camera.aspect)), v = std::max(v, std::abs(x.dot(above)) / half);
    }
    CHECK(std::max(h, v) == Approx(1 / 1.12).epsilon(1e-3));  // an eighth of margin; rounding of floats is below 1e-3
}

TEST_CASE("a lens is focused on the target by default, and a shutter is open for its share of a frame", "[render]") {
    CameraOptions camera;
    camera.kind = "fixed";
    camera.position = Vec3f(0, 0, 0.5f);
    CHECK_FALSE(view_at(camera, 0, low, high).blurs());
    camera.aperture = 0.01f;
    CHECK(view_at(camera, 0, low, high).focus == Approx(0.5));
    camera.focus = 0.3f;
    CHECK(view_at(camera, 0, low, high).focus == Approx(0.3));
    camera.kind = "orbit";
    camera.shutter = 180;
    camera.interval = 0.04;
    const View view = view_at(camera, 1, low, high);
    CHECK(view.open == Approx(0.02));
    const double speed = 20 * 3.14159265 / 180 * static_cast<double>(camera.distance);  // degrees a second along its circle
    CHECK(view.position_velocity.norm() == Approx(speed).epsilon(1e-3));
    CHECK(view.target_velocity.norm() < 1e-6f);
}
