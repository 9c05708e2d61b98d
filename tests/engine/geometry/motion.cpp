#include "engine/geometry/motion.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <numbers>

#include "engine/core/errors.h"
#include "engine/geometry/rigid_body.h"
#include "tests/support/animated_nodes.h"
#include "tests/support/scratch.h"

using namespace whorl;

namespace {

/// Largest difference of the rates that a motion states from central differences of its pose, at times from `from` to `to`.
double rate_error(const Motion& motion, double from, double to) {
    double most = 0;
    const double h = 1e-5;
    for (int k = 1; k < 100; ++k) {
        const double t = from + (to - from) * (k + 0.123) / 101;
        const MotionState now = motion.at(t), before = motion.at(t - h), after = motion.at(t + h);
        const Eigen::AngleAxisd turned(before.turn.conjugate() * after.turn);
        most = std::max(most, (now.velocity - (after.position - before.position) / (2 * h)).norm());
        most = std::max(most, (now.spin - turned.angle() / (2 * h) * turned.axis()).norm());
    }
    return most;
}

}  // namespace

TEST_CASE("keys move a solid through each key without overshoot, with rates exact to 1e-7", "[geometry]") {
    const std::vector<MotionKey> keys{
        {1, {0, 0, 0}, {0, 0, 0}}, {0.5, {0, 1, 0}, {0, 90, 0}}, {2, {3, 0, 0}, {10, 450, -30}}, {2.5, {3, 0, 1}, {0, 0, 0}}};
    const Motion motion = motion_of(keys);
    CHECK(motion.moves);
    CHECK(motion.turns);
    for (const MotionKey& key : keys) {
        const MotionState at = motion.at(key.time);
        CHECK((at.position - key.position).norm() < 1e-12);
        CHECK(at.turn.angularDistance(Eigen::Quaterniond(turn_by(std::numbers::pi / 180 * key.tilt))) < 1e-7);
    }
    for (double t = 0; t < 3; t += 0.01) {
        const Vec3d x = motion.at(t).position;
        REQUIRE((x.x() >= 0 && x.x() <= 3 && x.y() >= 0 && x.y() <= 1));
    }
    CHECK(motion.at(0).velocity.norm() + motion.at(0).spin.norm() + motion.at(3).velocity.norm() == 0);
    // The central difference over 2e-5 s misses the rate by h^2/6 times the third derivative, 1e-8; rounding of angles adds 1e-11/h.
    CHECK(rate_error(motion, 0.5, 2.5) < 1e-6);
}

TEST_CASE("a node moves with its parents, and linear keys give the exact velocity of its points", "[geometry]") {
    const test::ScratchFolder scratch;
    const double w = 2.5, end = 2;
    test::AnimatedNodes file = test::turning_node("Spoon", w, end, {0.2, 0.1, 0});
    const float half = std::sqrt(0.5f);
    file.track(0, "rotation", {0, 0.5f, 2}, {0, 0, 0, 1, half, 0, 0, half, -1, 0, 0, 0});  // a quarter turn about x, then another
    file.write(scratch / "spoon.glb");
    const AnimationFile::Node node = AnimationFile(scratch / "spoon.glb").node("Spoon");
    CHECK(node.motion.turns);
    CHECK_FALSE(node.fov);
    for (const double t : {0.1, 0.3, 0.9, 1.7}) {
        const double own_rate = t < 0.5 ? std::numbers::pi : std::numbers::pi / 3,
                     own_angle = t < 0.5 ? std::numbers::pi * t : std::numbers::pi / 2 + std::numbers::pi / 3 * (t - 0.5);
        const Eigen::Quaterniond rig(turn_by(Vec3d(0, w * t, 0))), turn = rig * Eigen::Quaterniond(turn_by(Vec3d(own_angle, 0, 0)));
        const MotionState at = node.motion.at(t);
        const Vec3d point(0, 0, 0.05);
        const Vec3d spin = at.turn * at.spin, expected_spin = Vec3d(0, w, 0) + rig * Vec3d(own_rate, 0, 0);
        const Vec3d velocity = at.velocity + spin.cross(at.turn * point),
                    expected = Vec3d(0, w, 0).cross(rig * Vec3d(0.2, 0.1, 0)) + expected_spin.cross(turn * point);
        // The file has quaternions and times in single precision: 1e-7 rad over the 0.3 s between keys.
        CHECK((at.position - rig * Vec3d(0.2, 0.1, 0)).norm() < 1e-6);
        CHECK(at.turn.angularDistance(turn) < 1e-6);
        CHECK((spin - expected_spin).norm() < 3e-6);
        CHECK((velocity - expected).norm() < 1e-6);
    }
    CHECK(node.motion.at(5).velocity.norm() == 0);
    CHECK((node.motion.at(5).position - node.motion.at(end).position).norm() == 0);
}

TEST_CASE("cubic keys of a node follow the spline of glTF, with rates exact to 1e-6", "[geometry]") {
    const test::ScratchFolder scratch;
    test::AnimatedNodes file;
    const int camera = file.node("eye", {{"camera", 0}, {"rotation", {0, 0, 1, 0}}});
    file.json["cameras"] = nlohmann::json::array({{{"type", "perspective"}, {"perspective", {{"yfov", 0.5}, {"znear", 0.1}}}}});
    file.track(camera, "translation", {1, 3}, {0, 0, 0, 1, 2, 3, 2, 0, 0, 0, -1, 0, 4, 2, 3, 0, 0, 0}, "CUBICSPLINE");
    const float half = std::sqrt(0.5f);
    file.track(camera, "rotation", {1, 3}, {0, 0, 0, 0, 0, 0, 0, 1, 0.3f, 0, 0, 0, 0, 0.2f, 0, 0, half, 0, 0, half, 0, 0, 0, 0},
               "CUBICSPLINE");
    file.write(scratch / "eye.glb");
    const AnimationFile::Node node = AnimationFile(scratch / "eye.glb").node("eye");
    REQUIRE(node.fov);
    CHECK(*node.fov == Approx(0.5 * 180 / std::numbers::pi));
    // x(1/2) = (v0 + v1)/2 + length (out0 - in1)/8
    CHECK((node.motion.at(2).position - Vec3d(2.5 + 2 * 2.0 / 8, 2 + 2 * 1.0 / 8, 3)).norm() < 1e-6);
    CHECK((node.motion.at(0).turn.angularDistance(Eigen::Quaterniond::Identity())) < 1e-6);
    // Second derivatives of some units: the central difference is exact to 1e-9.
    CHECK(rate_error(node.motion, 1, 3) < 1e-6);
}

TEST_CASE("unusable animations are refused by name", "[geometry]") {
    const test::ScratchFolder scratch;
    const auto message = [&](const std::function<void(test::AnimatedNodes&)>& change) -> std::string {
        test::AnimatedNodes file = test::turning_node("Spoon", 1, 1);
        change(file);
        file.write(scratch / "a.glb");
        try {
            AnimationFile(scratch / "a.glb").node("Spoon");
        } catch (const InputError& e) {
            const Problem& p = e.problems().front();
            return p.what + "|" + p.hint + "|" + p.allowed;
        }
        return "no error";
    };
    const std::string apply = "|apply its scale (in Blender: Object > Apply > Scale)|";
    CHECK(message([](auto&) {}) == "no error");
    CHECK(message([](auto& f) { f.json["nodes"][0]["scale"] = {1, 1.00005, 1}; }) == "no error");  // rounding of an exporter
    CHECK(message([](auto& f) { f.json["nodes"][0]["name"] = "Spon"; }) ==
          "a.glb has no node \"Spoon\"|did you mean \"Spon\"?|allowed: Spon, rig");
    CHECK(message([](auto& f) { f.node("Spoon"); }) == "a.glb has two nodes \"Spoon\"|rename one of them|");
    CHECK(message([](auto& f) { f.json["nodes"][0]["scale"] = {2, 2, 2}; }) == "node \"Spoon\" is scaled by [2, 2, 2]" + apply);
    CHECK(message([](auto& f) { f.json["nodes"][1]["scale"] = {1, -1, 1}; }) == "\"rig\", a parent of \"Spoon\", is mirrored" + apply);
    CHECK(message([](auto& f) { f.json["nodes"][0]["matrix"] = {0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}; }) ==
          "node \"Spoon\" is mirrored" + apply);
    CHECK(message([](auto& f) { f.json["nodes"][0]["matrix"] = {0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}; }) == "no error");
    CHECK(message([](auto& f) { f.track(0, "scale", {0, 1}, {1, 1, 1, 1, 2, 1}); }) == "node \"Spoon\" is scaled by [1, 2, 1]" + apply);
    CHECK(message([](auto& f) {
              f.track(0, "translation", {0, 1}, {0, 0, 0, 1, 0, 0}, "STEP");
          }) ==
          "node \"Spoon\" jumps from key to key (interpolation STEP)|use LINEAR or CUBICSPLINE (in Blender: linear or Bezier keyframes)|");
    CHECK(message([](auto& f) { f.track(0, "translation", {0, 1}, {0, 1, 0, 0, 1, 0}, "STEP"); }) == "no error");
    CHECK(message([](auto& f) {
              f.track(1, "rotation", {0}, {0, 0, 0, 1});
          }) == "\"rig\", a parent of \"Spoon\", has two animations of its rotation|keep one of them in the file|");
    CHECK(message([](auto& f) {
              f.track(0, "translation", {0, 0}, {0, 0, 0, 1, 0, 0});
          }).find("whose times do not increase") != std::string::npos);
    CHECK(message([](auto& f) { f.track(0, "translation", {0, 1}, {0, 0, 0}); }).find("has a damaged animation") != std::string::npos);
    CHECK(message([](auto& f) { f.json["accessors"][1]["count"] = 1000000; }).find("the file ends before its last key") !=
          std::string::npos);
    CHECK(message([](auto& f) { f.json["accessors"][1]["bufferView"] = 77; }).find("sparse accessor") != std::string::npos);
    CHECK(message([](auto& f) { f.json["accessors"][1]["componentType"] = 5122; }).find("numbers other than floats") != std::string::npos);
    CHECK(message([](auto& f) { f.json["accessors"][1]["type"] = "VEC3"; }).find("another type") != std::string::npos);
    CHECK_THROWS_WITH(AnimationFile("a.fbx"), Catch::Contains("\".fbx\" is not a kind of animation file; allowed: .gltf, .glb"));
    CHECK_THROWS_WITH(AnimationFile(scratch / "none.glb"), Catch::Contains("it is not a valid glTF 2.0 file: "));
}
