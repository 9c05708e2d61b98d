#include "render/look/camera.h"

#include <catch2/catch.hpp>

#include "render/look/look_options.h"

using namespace whorl;

namespace {
const Vec3f low(-0.1f, 0, -0.1f), high(0.1f, 0.2f, 0.1f);
}

TEST_CASE("a camera on keys passes through each of them and between them without a jump", "[render]") {
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

TEST_CASE("an orbit keeps its distance and comes round", "[render]") {
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

TEST_CASE("a lens is focused on the target unless the scene says where, and a shutter is open for its part of the time between pictures",
          "[render]") {
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
