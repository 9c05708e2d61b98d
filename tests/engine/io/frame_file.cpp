// Frames that are written whole and read back.
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>

#include "engine/core/errors.h"
#include "engine/io/csv.h"
#include "engine/io/frame.h"
#include "tests/support/scratch.h"

using namespace whorl;

namespace frame_file_test {

TEST_CASE("a frame reads back bit-identically, and a damaged file is named", "[io]") {
    Frame frame;
    frame.number = 7, frame.time = 0.1, frame.spacing = 0.01f, frame.dimensions = 2;
    frame.position = {{1, 2, 3}, {-4, 5e-20f, 6}};
    frame.velocity = {{0, 0, 1}, {1, 0, 0}};
    frame.scalar["density"] = {1000, 999.5f};
    frame.vector["ink"] = {{1, 0, 0}, {0, 1, 0.5f}};
    frame.whole["id"] = {5, 1 << 30};
    frame.domain_max = {1, 2, 3};
    frame.periodic = {true, false, true};
    FrameSolid solid;
    TriangleMesh mesh;
    mesh.position = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.triangle = {{0, 1, 2}};
    solid.mesh = std::make_shared<const TriangleMesh>(mesh);
    solid.rotation << 0, 1, 0, -1, 0, 0, 0, 0, 1;
    solid.translation = {0.1f, 0.2f, 0.3f};
    solid.velocity = {1, 2, 3}, solid.spin = {0, 0, -4};
    solid.appearance.material = "wood", solid.appearance.colour = {0.1f, 0.2f, 0.3f}, solid.container = true;
    solid.appearance.texture = "a.png", solid.appearance.texture_size = 0.1f, solid.appearance.texture_mesh = "a.obj";
    frame.solids = {solid, FrameSolid{}};
    frame.emitters = {{Vec3f(0, 1, 0), Vec3f(1, 0, 0), Vec3f(0, 0, 1), 0.02f, 0.01f, true}};

    const test::ScratchFolder folder;
    const std::filesystem::path file = folder / "000007.frame";
    write_frame(file, frame);
    const Frame back = read_frame(file);
    CHECK(back.number == 7);
    CHECK(back.time == 0.1);
    CHECK(back.spacing == 0.01f);
    CHECK(back.dimensions == 2);
    CHECK(back.position == frame.position);
    CHECK(back.velocity == frame.velocity);
    CHECK(back.scalar == frame.scalar);
    CHECK(back.vector == frame.vector);
    CHECK(back.whole == frame.whole);
    CHECK(back.domain_max == frame.domain_max);
    CHECK(back.periodic == frame.periodic);
    REQUIRE(back.solids.size() == 2);
    CHECK(back.solids[0].rotation == solid.rotation);
    CHECK(back.solids[0].translation == solid.translation);
    CHECK(back.solids[0].velocity == solid.velocity);
    CHECK(back.solids[0].spin == solid.spin);
    CHECK(back.solids[0].appearance == frame.solids[0].appearance);
    CHECK(back.solids[0].container);
    CHECK(back.solids[0].mesh->position == mesh.position);
    CHECK(back.solids[0].mesh->triangle == mesh.triangle);
    CHECK(back.solids[1].mesh == nullptr);
    REQUIRE(back.emitters.size() == 1);
    CHECK(back.emitters[0].position == Vec3f(0, 1, 0));
    CHECK(back.emitters[0].width_axis == Vec3f(0, 0, 1));
    CHECK(back.emitters[0].thickness == 0.01f);
    CHECK(back.emitters[0].slot);

    std::string bytes = read_whole(file);
    const auto refused = [&](const std::string& content, const std::string& why) {
        std::ofstream(file, std::ios::binary) << content;
        CHECK_THROWS_WITH(read_frame(file), Catch::Contains("000007.frame") && Catch::Contains(why));
    };
    refused(bytes.substr(0, bytes.size() - 5), "bytes of");
    refused("", "not of this kind");
    bytes[bytes.size() / 2] ^= 1;
    refused(bytes, "checksum");
}

TEST_CASE("a frame with inconsistent parts is refused", "[io]") {
    const test::ScratchFolder folder;
    const std::filesystem::path file = folder / "000001.frame";
    Frame frame;
    frame.spacing = 0.1f;
    frame.position = frame.velocity = {{1, 2, 3}, {4, 5, 6}};
    write_frame(file, frame);
    CHECK_NOTHROW(read_frame(file));
    TriangleMesh mesh;
    mesh.position = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    SECTION("a field with fewer values than particles") { frame.scalar["density"] = {1000}; }
    SECTION("fewer velocities") { frame.velocity.pop_back(); }
    SECTION("no spacing") { frame.spacing = 0; }
    SECTION("a position that is not a number") { frame.position[1].y() = NAN; }
    SECTION("a vertex at infinity") {
        mesh.position[2].x() = INFINITY;
        mesh.triangle = {{0, 1, 2}};
        frame.solids.emplace_back().mesh = std::make_shared<const TriangleMesh>(mesh);
    }
    SECTION("a periodic axis of zero length") {
        frame.domain_max = {1, 0, 1};
        frame.periodic = {false, true, false};
    }
    SECTION("a triangle with an invalid vertex index") {
        mesh.triangle = {{0, 1, 3}};
        frame.solids.emplace_back().mesh = std::make_shared<const TriangleMesh>(mesh);
    }
    write_frame(file, frame);
    CHECK_THROWS_WITH(read_frame(file), Catch::Contains("its arrays or values are inconsistent"));
}

}  // namespace frame_file_test
