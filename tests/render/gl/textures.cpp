/// Pictures on solids, and fluid of several colours.
#include <catch2/catch.hpp>
#include <fstream>

#include "engine/core/errors.h"
#include "engine/geometry/mesh_file.h"
#include "render/gl/renderer.h"
#include "render/look/texture_places.h"
#include "tests/support/scratch.h"
#include "tests/support/shapes.h"
#include "tools/scene_file/scene_file.h"

using namespace whorl;

namespace textures_test {

/// Red, green (above), blue, white (below).
void write_quarters(const std::filesystem::path& file) {
    Image image = plain_image(64, 64, 0);
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x) {
            const std::size_t at = 3 * static_cast<std::size_t>(64 * y + x);
            const bool right = x >= 32, low = y >= 32;
            image.rgb[at] = right == low ? 255 : 0, image.rgb[at + 1] = right ? 255 : 0, image.rgb[at + 2] = low ? 255 : 0;
        }
    write_png(file, image);
}

/// Largest channels of the pixel: 1 red, 2 green, 4 blue, 7 white.
int colour_at(const Image& image, int x, int y) {
    const auto p = image.pixel(x, y);
    const int most = std::max({p[0], p[1], p[2]});
    return (p[0] > 0.6 * most ? 1 : 0) + (p[1] > 0.6 * most ? 2 : 0) + (p[2] > 0.6 * most ? 4 : 0);
}

Image drawn(const FrameSolid& solid) {
    Frame frame;
    frame.spacing = 0.005f;
    frame.domain_min = Vec3f(-0.1f, -0.1f, -0.1f), frame.domain_max = Vec3f(0.1f, 0.1f, 0.1f);
    frame.solids.push_back(solid);
    LookOptions look;
    look.samples = 1, look.ground = false;
    Renderer renderer(160, 160);
    return renderer.draw(frame, {}, look, {Vec3f(0, 0, 0.6f), Vec3f::Zero(), Vec3f(0, 1, 0), 30});
}

TEST_CASE("a picture covers the front of a box once, upright, or repeats at its size", "[render]") {
    const test::ScratchFolder folder;
    write_quarters(folder / "a.png");
    FrameSolid box = test::solid_of(test::box_mesh(Vec3f(-0.1f, -0.1f, -0.01f), Vec3f(0.1f, 0.1f, 0.01f)), "white");
    box.appearance.texture = folder / "a.png";
    const Image once = drawn(box);
    CHECK(colour_at(once, 60, 60) == 1);
    CHECK(colour_at(once, 100, 60) == 2);
    CHECK(colour_at(once, 60, 100) == 4);
    CHECK(colour_at(once, 100, 100) == 7);
    // With half the width, the picture's middle stays at the box's, and each quarter is half as large.
    box.appearance.texture_size = 0.1f;
    const Image twice = drawn(box);
    CHECK(colour_at(twice, 74, 74) == 1);
    CHECK(colour_at(twice, 74 - 25, 74) == 2);
    box.appearance.colour = Colour(0, 0, 1);
    CHECK(colour_at(drawn(box), 86, 86) == 4);
}

TEST_CASE("the texture coordinates of an OBJ mesh place the picture, also after scaling", "[render]") {
    const test::ScratchFolder folder;
    write_quarters(folder / "a.png");
    // A square whose texture coordinates turn the picture by half a turn.
    std::ofstream(folder / "a.obj") << "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 1 1\nvt 0 1\nvt 0 0\nvt 1 0\nf 1/1 2/2 3/3 4/4\n";
    TriangleMesh mesh = read_mesh(folder / "a.obj", 0.1, Vec3d(0.01, 0, 0));
    mesh.normal.assign(mesh.position.size(), Vec3f::UnitZ());
    const auto places = texture_places(mesh, folder / "a.obj");
    REQUIRE(places.size() == 6);
    FrameSolid square = test::solid_of(mesh, "white");
    square.appearance.texture = folder / "a.png", square.appearance.texture_mesh = folder / "a.obj";
    const Image image = drawn(square);
    CHECK(colour_at(image, 60, 60) == 7);
    CHECK(colour_at(image, 110, 60) == 4);
    CHECK(colour_at(image, 60, 100) == 2);
    CHECK(colour_at(image, 110, 100) == 1);
    std::ofstream(folder / "plain.obj") << "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nf 1 2 3\n";
    CHECK(texture_places(mesh, folder / "plain.obj").empty());
}

const std::string scene =
    "[time]\nend = 1\n[domain]\nmin = [0, 0, 0]\nmax = [0.2, 0.2, 0.2]\n[fluid]\nspacing = 0.01\n[[block]]\nshape = \"box\"\nmin = [0, 0, "
    "0]\nmax = [0.1, "
    "0.1, 0.1]\n";

TEST_CASE("a texture that is no picture is refused at its key, and one that is edited changes the checksum", "[scene]") {
    const test::ScratchFolder folder;
    std::ofstream(folder / "a.png") << "no picture";
    std::ofstream(folder / "s.toml") << scene
                                     << "[[solid]]\nshape = \"box\"\nmin = [0, 0, 0]\nmax = [0.2, 0.01, 0.2]\ntexture = \"a.png\"\n";
    CHECK_THROWS_WITH(read_scene_file(folder / "s.toml"), Catch::Contains("s.toml:16:11") && Catch::Contains("cannot read the picture") &&
                                                              Catch::Contains("a PNG or JPEG file"));
    write_quarters(folder / "a.png");
    const auto before = input_checksums(read_scene_file(folder / "s.toml"));
    CHECK(before.size() == 1);
    write_png(folder / "a.png", plain_image(8, 8, 200));
    CHECK(input_checksums(read_scene_file(folder / "s.toml")) != before);
}

TEST_CASE("each colour of the fluid is an ink of its own after the named ones, also in the resolved scene", "[scene]") {
    const test::ScratchFolder folder;
    std::ofstream(folder / "s.toml")
        << scene << "ink = [1]\n[[block]]\nshape = \"box\"\nmin = [0.1, 0, 0]\nmax = [0.2, 0.1, 0.1]\ncolour = \"#20c040\"\n"
        << "[[emitter]]\nposition = [0.1, 0.19, 0.1]\nradius = 0.02\nspeed = 0.1\nfluid_colour = \"#2040c0\"\n"
        << "[[emitter]]\nposition = [0.05, 0.19, 0.1]\nradius = 0.02\nspeed = 0.1\nfluid_colour = \"#20c040\"\n";
    const SceneFile read = read_scene_file(folder / "s.toml");
    for (const SceneFile& file : {read, read_resolved(resolved_toml(read), folder / "s.toml")}) {
        CHECK(file.look.inks.of == std::vector<std::string>{"#c8281e", "#20c040", "#2040c0"});
        const auto ink = [&](const auto& one) { return file.scene.inks_of(one).vector()(0, Vec3d::Zero()); };
        CHECK(ink(file.scene.blocks[0]) == Vec3d(1, 0, 0));
        CHECK(ink(file.scene.blocks[1]) == Vec3d(0, 1, 0));
        CHECK(ink(file.scene.emitters[0]) == Vec3d(0, 0, 1));
        CHECK(ink(file.scene.emitters[1]) == Vec3d(0, 1, 0));
        CHECK(file.scene.any_ink());
    }
}

}  // namespace textures_test
