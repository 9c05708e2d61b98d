// The scene around the fluid as glTF 2.0.
#include "render/export/gltf.h"

#include <catch2/catch.hpp>
#include <fstream>

#include "engine/core/errors.h"
#include "engine/io/csv.h"
#include "render/image/image.h"
#include "tests/support/exported.h"
#include "tests/support/scratch.h"

using namespace whorl;

namespace gltf_test {

namespace {

/// A plate that turns about y and sinks, a fixed block, a nozzle with its emitter.
Frame frame_at(int number) {
    static const auto mesh = [] {
        TriangleMesh tetrahedron;
        const Vec3f corner[] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
        for (const auto& [a, b, c] : {std::array{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}) {
            const auto first = static_cast<std::uint32_t>(tetrahedron.position.size());
            for (const int k : {a, b, c}) tetrahedron.position.push_back(corner[k]);
            tetrahedron.normal.resize(first + 3, (corner[b] - corner[a]).cross(corner[c] - corner[a]).normalized());
            tetrahedron.triangle.push_back({first, first + 1, first + 2});
        }
        return std::make_shared<const TriangleMesh>(tetrahedron);
    }();
    Frame frame;
    frame.number = number, frame.time = 0.02 * (number - 1);
    frame.domain_max = Vec3f::Constant(1);
    const auto k = static_cast<float>(number - 1);
    FrameSolid plate, block, nozzle;
    plate.mesh = block.mesh = nozzle.mesh = mesh;
    plate.appearance.material = "wood", block.container = true, nozzle.appearance.material = "metal";
    plate.rotation = Eigen::AngleAxisf(0.7f * k, Vec3f::UnitY()).toRotationMatrix();
    plate.translation = Vec3f(0, -0.1f * k, 0);
    frame.solids = {plate, block, nozzle};
    frame.emitters = {{Vec3f(0, 2, 0), Vec3f(0, -1, 0), Vec3f(1, 0, 0), 0.02f, 0.02f, false}};
    return frame;
}

View view_at_frame(int number) {
    const auto k = static_cast<float>(number - 1);
    return {Vec3f(3 + k, 0, 0), Vec3f::Zero(), Vec3f::UnitY(), 30 + k};
}

}  // namespace

TEST_CASE("a glTF scene has moving solids, emitters, the camera and the lamp", "[export]") {
    const test::ScratchFolder folder;
    SceneExport scene({"two", 25, 0.02, 160, 90});
    for (int number = 1; number <= 12; ++number) scene.add(frame_at(number), view_at_frame(number), {});
    scene.write(folder / "a.glb");
    const test::Glb glb = test::read_glb(folder / "a.glb");
    CHECK(glb.json["asset"]["version"] == "2.0");
    CHECK(glb.json["buffers"][0]["byteLength"] == glb.binary.size());

    // One key per frame at number/fps s; fixed nodes have no keys.
    const auto& animation = glb.json["animations"][0];
    const std::vector<float> times = glb.floats(animation["samplers"][0]["input"].get<std::size_t>());
    REQUIRE(times.size() == 12);
    CHECK(times[0] == 1 / 25.0f);
    CHECK(times[11] == 12 / 25.0f);
    const std::vector<float> place = glb.keys("solid[0]", "translation"), turn = glb.keys("solid[0]", "rotation");
    REQUIRE(turn.size() == 4 * 12);
    for (int k = 0; k < 12; ++k) {
        CHECK(place[3 * k + 1] == frame_at(k + 1).solids[0].translation.y());
        // Half the angle, without a jump to the opposite sign beyond a whole turn.
        CHECK(turn[4 * k + 3] == Approx(std::cos(0.35 * k)).margin(1e-5));
        CHECK(turn[4 * k + 1] == Approx(std::sin(0.35 * k)).margin(1e-5));
    }
    CHECK(glb.keys("solid[1]", "translation").empty());
    CHECK(glb.keys("nozzle[0]", "translation").empty());

    const auto camera = glb.node("camera");
    CHECK(camera["translation"] == nlohmann::json{3.0, 0.0, 0.0});
    const Eigen::Quaternionf q(camera["rotation"][3], camera["rotation"][0], camera["rotation"][1], camera["rotation"][2]);
    CHECK((q * Vec3f(0, 0, -1) - Vec3f(-1, 0, 0)).norm() < 1e-6f);  // it looks along -z: from x = 3 to the origin
    CHECK((q * Vec3f::UnitY() - Vec3f::UnitY()).norm() < 1e-6f);
    CHECK(glb.json["cameras"][0]["perspective"]["yfov"].get<float>() == Approx(30 * 3.14159265 / 180));
    CHECK(glb.json["scenes"][0]["extras"]["whorl"]["fov_degrees"][11] == 41.0);

    const auto emitter = glb.node("emitter[0]");
    CHECK_FALSE(emitter.contains("mesh"));
    CHECK(emitter["extras"]["width"].get<float>() == 0.02f);
    const Eigen::Quaternionf e(emitter["rotation"][3], emitter["rotation"][0], emitter["rotation"][1], emitter["rotation"][2]);
    CHECK((e * Vec3f(0, 0, -1) - Vec3f(0, -1, 0)).norm() < 1e-6f);  // the flow goes along -z

    // All three solids have one shape, each with its own material.
    REQUIRE(glb.json["meshes"].size() == 3);
    const auto& primitive = glb.json["meshes"][0]["primitives"][0];
    const std::size_t position = primitive["attributes"]["POSITION"].get<std::size_t>();
    CHECK(glb.floats(position).size() == 12 * 3);  // four corners, each with three creases
    CHECK(glb.json["accessors"][position]["max"] == nlohmann::json{1.0, 1.0, 1.0});
    CHECK(glb.json["accessors"][primitive["indices"].get<std::size_t>()]["count"] == 12);
    CHECK(glb.json["extensionsUsed"] == nlohmann::json{"KHR_lights_punctual"});
    CHECK(glb.node("lamp")["extensions"]["KHR_lights_punctual"]["light"] == 0);
}

TEST_CASE("a glTF scene has the refraction of glass and ice, and the pictures on solids", "[export]") {
    const test::ScratchFolder folder;
    Image image;
    image.width = 2, image.height = 1, image.rgb = {255, 0, 0, 0, 0, 255};
    write_png(folder / "p.png", image);
    Frame frame = frame_at(1);
    frame.solids[0].appearance.texture = folder / "p.png", frame.solids[0].appearance.texture_size = 1.0f;
    frame.solids[2].appearance.material = "ice";
    SceneExport scene({"glass", 25, 0.02, 160, 90});
    scene.add(frame, view_at_frame(1), {});
    scene.write(folder / "a.glb");
    const test::Glb glb = test::read_glb(folder / "a.glb");
    const auto material = [&](const char* node) {
        const auto& mesh = glb.json["meshes"][glb.node(node)["mesh"].get<std::size_t>()];
        return glb.json["materials"][mesh["primitives"][0]["material"].get<std::size_t>()];
    };
    const auto ice = material("nozzle[0]")["extensions"];
    CHECK(material("nozzle[0]")["pbrMetallicRoughness"]["roughnessFactor"] == 0);  // clear, not frosted
    CHECK(ice["KHR_materials_transmission"]["transmissionFactor"] == 1);
    CHECK(ice["KHR_materials_ior"]["ior"].get<float>() == 1.31f);
    const double reds = ice["KHR_materials_volume"]["attenuationColor"][0], deep = ice["KHR_materials_volume"]["attenuationDistance"];
    CHECK(reds == Approx(std::exp(-2.5 * deep)));              // absorption of red in ice: 2.5 1/m
    CHECK_FALSE(material("solid[1]").contains("extensions"));  // the walls of a container have no thickness
    CHECK(glb.json["extensionsUsed"].size() == 4);

    CHECK(material("solid[0]")["pbrMetallicRoughness"]["baseColorTexture"]["index"] == 0);
    const auto& view = glb.json["bufferViews"][glb.json["images"][0]["bufferView"].get<std::size_t>()];
    CHECK(glb.binary.substr(view["byteOffset"].get<std::size_t>(), view["byteLength"].get<std::size_t>()) == read_whole(folder / "p.png"));
    // The first face is seen along +z, so x points to the left: corners (0, 0), (0, 1) and (1, 0) of a picture 1 m wide and 0.5 m high.
    const std::vector<float> place = glb.floats(glb.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"].get<std::size_t>());
    REQUIRE(place.size() == 12 * 2);
    CHECK(std::vector<float>(place.begin(), place.begin() + 6) == std::vector<float>{1, 1.5f, 1, -0.5f, 0, 1.5f});
}

TEST_CASE("a resumed run continues its glTF scene to the same file, and names a damaged one", "[export]") {
    const test::ScratchFolder folder;
    SceneExport whole({"two", 25, 0.02, 160, 90}), first = whole, second = whole;
    for (int number = 1; number <= 9; ++number) whole.add(frame_at(number), view_at_frame(number), {});
    for (int number = 1; number <= 6; ++number) first.add(frame_at(number), view_at_frame(number), {});
    whole.write(folder / "whole.glb"), first.write(folder / "part.glb");
    second.go_on_from(folder / "part.glb", 4);  // frames after the checkpoint are made again
    for (int number = 5; number <= 9; ++number) second.add(frame_at(number), view_at_frame(number), {});
    second.write(folder / "part.glb");
    const test::Glb a = test::read_glb(folder / "whole.glb"), b = test::read_glb(folder / "part.glb");
    for (const char* node : {"solid[0]", "camera"})
        for (const char* path : {"translation", "rotation"}) CHECK(a.keys(node, path) == b.keys(node, path));
    CHECK(a.json["scenes"] == b.json["scenes"]);
    CHECK(a.json["cameras"] == b.json["cameras"]);

    SceneExport none({"two", 25, 0.02, 160, 90});
    CHECK_NOTHROW(none.go_on_from(folder / "nowhere.glb", 4));
    std::string more = read_whole(folder / "part.glb");
    more.replace(more.find("\"solids\":3"), 10, "\"solids\":9");
    std::ofstream(folder / "more.glb", std::ios::binary) << more;
    CHECK_THROWS_WITH(none.go_on_from(folder / "more.glb", 4), Catch::Contains("more.glb") && Catch::Contains("key frames are missing"));
    std::ofstream(folder / "part.glb", std::ios::app) << "x";
    CHECK_THROWS_WITH(none.go_on_from(folder / "part.glb", 4),
                      Catch::Contains("part.glb") && Catch::Contains("not a complete glTF 2.0 file"));
}

}  // namespace gltf_test
