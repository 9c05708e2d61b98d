// Scenes of SPlisHSPlasH, written for these tests from that program's documentation of its format.
#include <zlib.h>

#include <bit>
#include <catch2/catch.hpp>
#include <fstream>

#include "engine/geometry/mesh_file.h"
#include "engine/io/csv.h"
#include "engine/scene/plan.h"
#include "tests/support/program.h"
#include "tests/support/scratch.h"
#include "tools/convert/splishsplash.h"
#include "tools/scene_file/scene_file.h"

using namespace whorl;

namespace import_test {

namespace {

const std::string tank = R"({
  // a tank, a block that falls into it, a jet
  "Configuration": {
    "pause": true,
    "particleRadius": 0.02,
    "simulationMethod": 4,
    "gravitation": [0, -10, 0],
    "cflMethod": 1, "cflFactor": 0.5, "cflMaxTimeStepSize": 0.004,
    "maxError": 0.05, "maxIterations": 80,
    "stopAt": 2.5,
    "cameraPosition": [0, 3, 8], "cameraLookat": [0, 1, 0]
  },
  "Materials": [
    {"id": "Fluid", "density0": 900, "viscosityMethod": 7, "viscosity": 0.5,
     "dragMethod": 2, "drag": 0.3},
    {"id": "Thick", "density0": 900, "viscosityMethod": 1, "viscosity": 2}
  ],
  "FluidBlocks": [
    {"start": [-0.5, 0, -0.5], "end": [0.5, 1, 0.5], "translation": [0, 0.25, 0], "scale": [1, 2, 1], "initialVelocity": [0, -1, 0]}
  ],
  "Emitters": [
    {"id": "Thick", "width": 5, "height": 3, "translation": [-0.9, 1.5, 0], "velocity": 2,
     "rotationAxis": [0, 1, 0], "rotationAngle": 3.14159265358979, "emitEndTime": 1.5},
    {"type": 1, "width": 4, "translation": [0, 2.5, 0], "rotationAxis": [0, 0, 1], "rotationAngle": -1.5707963267948966}
  ],
  "RigidBodies": [
    {"geometryFile": "../models/UnitBox.obj", "translation": [0, 1.5, 0], "scale": [2, 3, 2], "isWall": true, "mapInvert": true,
     "mapResolution": [20, 20, 20], "color": [0.1, 0.4, 0.6, 1]},
    {"geometryFile": "wedge.obj", "translation": [0.4, 0, 0], "scale": [1, 0.5, 1], "rotationAxis": [0, 1, 0], "rotationAngle": 1.5707963267948966},
    {"geometryFile": "../models/UnitBox.obj", "translation": [0.6, 2.6, 0.6], "scale": [0.2, 0.2, 0.2], "isDynamic": true, "density": 400}
  ]
})";

struct Scratch : test::ScratchFolder {
    std::string file() const { return *this / "scene.json"; }
    explicit Scratch(const std::string& text = tank) {
        std::ofstream(*this / "scene.json") << text;
        std::ofstream(*this / "wedge.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
    }
};

bool noted(const ConvertedScene& made, int line, const std::string& what) {
    return std::any_of(made.notes.begin(), made.notes.end(),
                       [&](const Problem& note) { return note.place.line == line && note.what.find(what) != std::string::npos; });
}

}  // namespace

TEST_CASE("import makes a valid scene from SPlisHSPlasH's, and lists keys without an equivalent", "[tools][import]") {
    const Scratch scratch;
    const std::string out = (scratch / "tank.toml").string();
    const test::Outcome outcome = test::succeed({"import", scratch.file(), "--out", out});
    CHECK(outcome.out.find("to be fixed first") == std::string::npos);
    CHECK_THAT(outcome.out, Catch::Contains(scratch.file() + ":4:5: Configuration.pause has no equivalent: left out\n"));

    const Scene scene = read_scene_file(out).scene;
    CHECK_NOTHROW(make_plan(scene));
    CHECK(scene.time.end == 2.5);
    CHECK(scene.time.max_step == 0.004);
    CHECK(scene.time.cfl == Approx(0.2));
    CHECK(scene.fluid.spacing == 0.04);
    CHECK(scene.fluid.density == 900);
    CHECK(scene.fluid.viscosity(0) == 450);  // kinematic viscosity times density
    CHECK(scene.models.pressure == PressureModel::ppe);
    CHECK(scene.pressure.limits.tolerance == Approx(5e-4));  // per cent
    CHECK(scene.domain.gravity(0) == Vec3d(0, -10, 0));
    REQUIRE(scene.blocks.size() == 1);
    CHECK(scene.blocks[0].shape.min == Vec3d(-0.5, 0.25, -0.5));
    CHECK(scene.blocks[0].shape.max == Vec3d(0.5, 2.25, 0.5));
    CHECK(scene.blocks[0].velocity(0, Vec3d::Zero()) == Vec3d(0, -1, 0));
    REQUIRE(scene.emitters.size() == 2);
    CHECK((scene.emitters[0].direction(0) - Vec3d(-1, 0, 0)).norm() < 1e-8);
    CHECK(scene.emitters[0].width == Approx(0.2));
    CHECK(scene.emitters[0].thickness == Approx(0.12));
    CHECK(scene.emitters[0].stop == 1.5);
    REQUIRE(scene.emitters[0].viscosity.has_value());
    CHECK((*scene.emitters[0].viscosity)(0) == 1800);
    CHECK(scene.emitters[1].radius == Approx(0.08));
    CHECK((scene.emitters[1].direction(0) - Vec3d(0, -1, 0)).norm() < 1e-8);
    REQUIRE(scene.solids.size() == 3);
    CHECK(scene.solids[0].container);
    CHECK(scene.solids[0].shape.max == Vec3d(1, 3, 1));
    CHECK(scene.solids[2].density == 400);
    CHECK(scene.solids[1].shape.file.filename() == "tank_body_1.obj");  // so that several scenes can be imported into one folder
    // The mesh is rotated about y and half as high in its file.
    const TriangleMesh wedge = read_mesh(scratch / scene.solids[1].shape.file.filename());
    Vec3f low = wedge.position[0], high = low;
    for (const Vec3f& x : wedge.position) low = low.cwiseMin(x), high = high.cwiseMax(x);
    CHECK((low - Vec3f(0.4f, 0, -1)).norm() < 1e-5f);
    CHECK((high - Vec3f(1.4f, 0.5f, 0)).norm() < 1e-5f);

    const ConvertedScene made = convert_splishsplash(scratch.file());
    CHECK(noted(made, 6, "simulationMethod is taken as models.pressure"));
    CHECK(noted(made, 15, "Materials[0].dragMethod has no equivalent"));
    CHECK(noted(made, 14, "Materials[0].viscosity is taken as a kinematic viscosity in m^2/s: 450.0 Pa s"));
    CHECK(noted(made, 24, "Emitters[1].width is a number of particles; the diameter is 0.16 m"));
    CHECK(noted(made, 28, "RigidBodies[0].mapResolution has no equivalent"));
    CHECK_FALSE(noted(made, 28, "scale"));

    CHECK_THAT(test::refusal({"import", scratch.file(), "--out", out}), Catch::Contains("tank.toml: already exists"));
}

TEST_CASE("import reports file, line and column of a fault, and writes nothing", "[tools][import]") {
    const auto refused = [](const std::string& text, const std::string& why) {
        const Scratch scratch(text);
        CHECK_THAT(test::refusal({"import", scratch.file(), "--out", (scratch / "made.toml").string()}),
                   Catch::Contains(scratch.file() + why));
        CHECK_FALSE(std::filesystem::exists(scratch / "made.toml"));
    };
    refused("{\n  \"Configuration\": {\"particleRadius\": 0.02,, }\n}", ":2:");
    refused("{\n  \"Configuration\": {\"particleRadius\": 0.02", ":2:");
    refused("{\n  \"Configuration\": {\"particleRadius\": \"small\"}\n}", ":2:21: Configuration.particleRadius is not a number");
    refused("{\n \"FluidBlocks\": [\n  {\"start\": [0, 0], \"end\": [1, 1, 1]}]\n}",
            ":3:4: FluidBlocks[0].start is not a list of three numbers");
    refused("{\n \"FluidBlocks\": [\n  {\"start\": [0, 0, 0]}]\n}", ":3:3: FluidBlocks[0] has no end");
    refused("{\n \"RigidBodies\": [\n  {\"geometryFile\": \"gone.obj\"}]\n}", ":3:4: RigidBodies[0].geometryFile: ");
    refused("{\n \"RigidBodies\": [\n  {\"geometryFile\": \"" + std::string(256, 'a') + "\"}]\n}", ":3:4: RigidBodies[0].geometryFile: ");
    refused("{\n \"RigidBodies\": [\n  {\"geometryFile\": \"/dev/zero\"}]\n}", ":3:4: RigidBodies[0].geometryFile: ");
    refused(std::string(200'000, '['), ":1:101: more than 100 brackets are open");
    refused("[1, 2]", ":1:1: is not a scene");
    CHECK(test::whorl({"import", "nowhere.json"}).code == 2);
    const test::ScratchFolder folder;
    CHECK_THAT(test::refusal({"import", folder.path().string()}), Catch::Contains("is a folder, not a file"));
}

TEST_CASE("out-of-range numbers and file names of any bytes still give a readable scene", "[tools][import]") {
    const Scratch scratch;
    const std::filesystem::path file = scratch / "a\nb = 1 \xfc.json";
    std::ofstream(file) << R"({"Configuration": {"particleRadius": 0.05, "maxIterations": 1e30},
 "Materials": [{"viscosityMethod": 1e300, "viscosity": 1}], "FluidBlocks": [{"start": [-1, 0, -1], "end": [0, 1, 1]}]})";
    const ConvertedScene made = convert_splishsplash(file);
    CHECK(made.toml.rfind("# From a?b = 1 ?.json by whorl import.\n", 0) == 0);
    CHECK(noted(made, 2, "is a coefficient without unit"));
    std::ofstream(scratch / "made.toml") << made.toml;
    CHECK(read_scene_file(scratch / "made.toml").scene.pressure.limits.max_iterations == 1'000'000'000);
}

TEST_CASE("import reads parameters of a method's section by that format's method numbers", "[tools][import]") {
    const auto made = [](const std::string& material) {
        return convert_splishsplash(
                   Scratch(R"({"Configuration": {"particleRadius": 0.01, "stopAt": 1, "simulationMethod": 4, "DFSPH": {"maxError": 0.05},
 "cflMethod": 0, "timeStepSize": 0.002},
 "Materials": [{"id": "Fluid", "density0": 1200, )" +
                           material + R"(}],
 "FluidBlocks": [{"start": [0, 0, 0], "end": [0.2, 0.2, 0.2], "initialVelocity": [3, 0, 0]}]})") /
                   "scene.json")
            .toml;
    };
    const auto has = [](const std::string& toml, const std::string& line) { return toml.find("\n" + line + "\n") != std::string::npos; };
    const std::string standard = made(R"("viscosityMethod": 1, "Standard viscosity": {"viscosity": 2.5})");
    CHECK(has(standard, "viscosity = 3000.0"));
    CHECK(has(standard, "tolerance = 0.0005"));
    CHECK(has(standard, "max_step = 0.002"));
    CHECK(has(made(R"("viscosityMethod": 6, "Weiler et al. 2018": {"viscosity": 5, "viscosityBoundary": 4})"), "viscosity = 6000.0"));
    CHECK(has(made(R"("viscosityMethod": 6, "Standard viscosity": {"viscosity": 1}, "Weiler et al. 2018": {"viscosity": 5})"),
              "viscosity = 6000.0"));  // the section of the chosen method
    const std::string bender =
        made(R"("viscosityMethod": 2, "Bender and Koschier 2017": {"viscosity": 0.5})");  // 2 meant XSPH in older versions
    CHECK(has(bender, "viscosity = 0.0"));
    CHECK_FALSE(has(bender, "viscosity = \"xsph\""));
    const auto is_water = [&](const std::string& toml) { return has(toml, "material = \"water\""); };
    CHECK(is_water(made(R"("viscosityMethod": 1, "Standard viscosity": {"viscosity": 0.01})")));
    CHECK_FALSE((is_water(standard) || is_water(bender)));
    const std::string thin = made(
        R"("viscosityMethod": 1, "Standard viscosity": {"viscosity": 1e-6}, "vorticityMethod": 1,
 "Bender et al. 2017": {"vorticity": 0.1, "viscosityOmega": 0.2, "inertiaInverse": 0.5})");
    CHECK(has(thin, "transfer_viscosity = 120.0"));
    CHECK(has(thin, "micro_inertia = 2.0"));
    CHECK(has(thin, "xsph_spin = 0.1"));
}

TEST_CASE("particles of a .bgeo file, packed or not, become a block of the same volume", "[tools][import]") {
    const double d = 0.02;
    std::string bytes = "BgeoV";
    const auto put = [&](std::uint32_t value, int size) {
        while (size-- > 0) bytes += static_cast<char>(value >> (8 * size));
    };
    put(5, 4);
    for (const std::uint32_t count : {1000, 0, 0, 0, 2, 0, 0, 0}) put(count, 4);
    put(2, 2), bytes += "id", put(1, 2), put(1, 4), put(0, 4);
    put(4, 2), bytes += "kind", put(1, 2), put(4, 4), put(1, 4), put(3, 2), bytes += "wet";  // one of several strings
    for (int k = 0; k < 1000; ++k) {
        for (const int along : {k % 10, k / 10 % 10, k / 100}) put(std::bit_cast<std::uint32_t>(static_cast<float>(d * along)), 4);
        put(std::bit_cast<std::uint32_t>(1.0f), 4), put(k, 4), put(0, 4);
    }
    const Scratch scratch(R"({"Configuration": {"particleRadius": 0.01, "stopAt": 1},
 "FluidModels": [{"particleFile": "cube.bgeo", "translation": [0, 1, 0]}]})");
    const auto volume = [&] {
        const ConvertedScene made = convert_splishsplash(scratch.file());
        const TriangleMesh& mesh = made.meshes.at(0).second;
        double six = 0;
        for (const auto& t : mesh.triangle)
            six += mesh.position[t[0]].cast<double>().dot(mesh.position[t[1]].cast<double>().cross(mesh.position[t[2]].cast<double>()));
        return six / 6;
    };
    std::ofstream(scratch / "cube.bgeo") << bytes;
    const double plain = volume();
    CHECK(plain == Approx(1000 * d * d * d).epsilon(0.06));  // edges and corners are round
    const gzFile packed = gzopen((scratch / "cube.bgeo").c_str(), "wb");
    gzwrite(packed, bytes.data(), static_cast<unsigned>(bytes.size()));
    gzclose(packed);
    CHECK(volume() == plain);
    std::ofstream(scratch / "cube.bgeo") << bytes.substr(0, 900);
    CHECK_THROWS_WITH(convert_splishsplash(scratch.file()), Catch::Contains("particleFile") && Catch::Contains("ends too early"));
}

TEST_CASE("an imported 2D scene has two coordinates, and a scene without an end is reported", "[tools][import]") {
    const Scratch scratch(R"({"Configuration": {"sim2D": true, "particleRadius": 0.025, "cflMethod": 0, "timeStepSize": 0.002,
   "gravitation": [0, -9810, 0]},
 "FluidBlocks": [{"start": [-1, 0, -1], "end": [0, 1, 1]}],
 "Emitters": [{"width": 4, "height": 2, "translation": [0.5, 1.5, 0]}],
 "RigidBodies": [{"geometryFile": "UnitBox.obj", "translation": [0, 1, 0], "scale": [2, 2, 1], "isWall": true}]})");
    const std::string out = (scratch / "plane.toml").string();
    const test::Outcome outcome = test::succeed({"import", scratch.file(), "--out", out});
    CHECK(outcome.out.find("the scene never ends (no stopAt): time.end is 5 s") != std::string::npos);
    CHECK(outcome.out.find("taken as a container") != std::string::npos);
    CHECK(outcome.out.find("to be fixed first") == std::string::npos);
    CHECK(outcome.out.find("warning: domain.gravity = 9810 is 1e+03 times") != std::string::npos);
    const Scene scene = read_scene_file(out).scene;
    CHECK(scene.domain.dimensions == 2);
    CHECK(scene.time.max_step == 0.002);
    CHECK(scene.solids[0].container);
}

}  // namespace import_test
