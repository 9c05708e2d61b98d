// Solids and emitters that keys and animations move.
#include <catch2/catch.hpp>
#include <filesystem>

#include "engine/scene/read.h"
#include "tests/support/animated_nodes.h"
#include "tests/support/runs.h"
#include "tests/support/scene_text.h"
#include "tests/support/scratch.h"

using namespace whorl;

namespace {

const std::string honey_cup = test::text::time(0.03) + test::text::domain({-0.04, -0.01, -0.04}, {0.04, 0.06, 0.04}) +
                              test::text::fluid(0.005, 5, "density = 1400") + test::text::models("coupled") +
                              test::text::block({-0.03, 0, -0.03}, {0.03, 0.03, 0.03}) +
                              test::text::tank({-0.03, 0, -0.03}, {0.03, 0.1, 0.03});

/// Impulse of the fluid on the last solid until 0.03 s.
Wrench impulse_on(const std::string& solid) {
    Simulation s = test::simulation_of(honey_cup + solid + "[[probe]]\nname = \"paddle\"\nkind = \"solid\"\nsolid = 1\n");
    Wrench sum;
    test::run_until(s, 0.03, [&] { sum += s.world().solids.all.back().ledger.total(); });
    return sum;
}

}  // namespace

TEST_CASE("a solid moved by keys and by the expression of the same motion drags fluid alike, to 1e-3", "[geometry][simulation]") {
    const std::string paddle = "[[solid]]\nshape = \"box\"\nmin = [-0.01, 0.01, -0.0025]\nmax = [0.01, 0.04, 0.0025]\n";
    const std::string keys =
        "[[solid.key]]\ntime = 0\n[[solid.key]]\ntime = 0.04\nposition = [0.008, 0, 0]\ntilt = [0, 30, 0]\n[[solid.key]]\ntime = 0.05\n"
        "position = [0.008, 0, 0]\ntilt = [0, 30, 0]\n";
    // The first span starts with its mean slope and ends at rest: x = s + s^2 - s^3, s = t/0.04.
    const Wrench by_keys = impulse_on(paddle + keys);
    const Wrench by_expression = impulse_on(paddle +
                                            "position = [\"0.008*(25*t + (25*t)^2 - (25*t)^3)\", 0, 0]\n"
                                            "rotation = [0, \"pi/6*(25 + 1250*t - 46875*t^2)\", 0]\n");
    REQUIRE(by_expression.force.x() < -1e-4);
    // The poses agree to rounding, which grows during the run.
    CHECK((by_keys.force - by_expression.force).norm() < 1e-3 * by_expression.force.norm());
    CHECK((by_keys.torque - by_expression.torque).norm() < 1e-3 * by_expression.torque.norm());
}

TEST_CASE("a stirrer that follows a node of a glTF file drags honey as the same stirrer by expression, to 1e-3", "[geometry][simulation]") {
    const test::ScratchFolder scratch;
    test::turning_node("Stirrer", 6, 1, {0, 0.02, 0}).write(scratch / "stir.glb");
    const std::string file = "animation = \"" + (scratch / "stir.glb").string() + "\"\nnode = \"Stirrer\"\n";
    const Wrench by_node = impulse_on("[[solid]]\nshape = \"box\"\nmin = [-0.015, -0.01, -0.0025]\nmax = [0.015, 0.02, 0.0025]\n" + file);
    const Wrench by_expression =
        impulse_on("[[solid]]\nshape = \"box\"\nmin = [-0.015, 0.01, -0.0025]\nmax = [0.015, 0.04, 0.0025]\nrotation = [0, 6, 0]\n");
    REQUIRE(by_expression.torque.y() < -1e-6);
    // The file states the rotation in single precision, and rounding of positions grows during the run.
    CHECK((by_node.torque - by_expression.torque).norm() < 1e-3 * by_expression.torque.norm());
}

TEST_CASE("an emitter follows keys or a node, with its position added and its direction turned", "[geometry][scene]") {
    const test::ScratchFolder scratch;
    test::turning_node("Nozzle", std::acos(-1.0) / 2, 1, {0.1, 0, 0}).write(scratch / "nozzle.glb");
    const auto emitter_of = [&](const std::string& keys) {
        return read_scene_text(test::text::time(1) + test::text::domain({-1, -1, -1}, {1, 1, 1}) + test::text::fluid(0.01) +
                                   "[[emitter]]\nradius = 0.05\nspeed = 1\n" + keys,
                               (scratch / "scene.toml").string())
            .emitters[0];
    };
    const EmitterKeys on_node =
        emitter_of("animation = \"nozzle.glb\"\nnode = \"Nozzle\"\nposition = [0, 0.2, 0]\ndirection = [1, 0, 0]\n");
    CHECK((on_node.position(0) - Vec3d(0.1, 0.2, 0)).norm() < 1e-7);
    CHECK((on_node.position(1) - Vec3d(0, 0.2, -0.1)).norm() < 1e-7);
    CHECK((on_node.direction(1) - Vec3d(0, 0, -1)).norm() < 1e-6);
    CHECK(on_node.moves());
    const EmitterKeys on_keys = emitter_of(
        "position = [0, \"0.1*t\", 0]\n[[emitter.key]]\ntime = 0\nposition = [0, 0, 0]\n[[emitter.key]]\ntime = 1\n"
        "position = [0.2, 0, 0]\ndirection = [1, 0, 0]\n");
    CHECK((on_keys.position(0.5) - Vec3d(0.1, 0.05, 0)).norm() < 1e-12);
    CHECK((on_keys.direction(0.5) - Vec3d(0.5, -0.5, 0)).norm() < 1e-12);
}
