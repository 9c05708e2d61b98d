// Particles, meshes and grids as other programs read them: every array reads back bit-identically.
#include <catch2/catch.hpp>

#include "engine/core/errors.h"
#include "engine/io/csv.h"
#include "render/export/attributes.h"
#include "render/export/gltf.h"
#include "tests/support/exported.h"
#include "tests/support/scratch.h"

using namespace whorl;

namespace tables_test {

namespace {

/// Some particles with every field, a column of the solver's among them.
Frame some_frame(std::size_t count = 600) {
    Frame frame;
    frame.number = 12, frame.time = 11.0 / 24, frame.spacing = 0.1f;
    frame.domain_max = Vec3f::Constant(2);
    for (std::size_t i = 0; i < count; ++i) {
        const auto a = static_cast<float>(i);
        frame.position.push_back(Vec3f(1 + std::sin(a), 1 + std::sin(7 * a), 1 + std::cos(3 * a)));
        frame.velocity.push_back(Vec3f(std::sin(a), -1e-20f * a, 3));
        frame.vector["spin"].push_back(Vec3f(0, 0, a));
        frame.vector["ink"].push_back(Vec3f(1, 0.5f, 0));
        frame.scalar["density"].push_back(1000 + a);
        frame.scalar["age"].push_back(0.25f * a);
        frame.scalar["grain"].push_back(a);
        frame.whole["id"].push_back((1 << 30) + static_cast<std::int32_t>(i));  // larger than a float can represent exactly
        frame.whole["source"].push_back(1);
        frame.whole["role"].push_back(-1);
    }
    return frame;
}

std::vector<float> component(const std::vector<Vec3f>& values, int c) {
    std::vector<float> all;
    for (const Vec3f& v : values) all.push_back(v[c]);
    return all;
}

std::vector<float> flat(const std::vector<Vec3f>& values) {
    std::vector<float> all;
    for (const Vec3f& v : values) all.insert(all.end(), {v.x(), v.y(), v.z()});
    return all;
}

}  // namespace

TEST_CASE("a PLY of particles contains the exported fields bit for bit, with units, and no solver fields", "[export]") {
    const test::ScratchFolder folder;
    const Frame frame = some_frame();
    write_ply(folder / "a.ply", frame, particle_attributes(frame));
    const test::Ply ply = test::read_ply(folder / "a.ply");
    CHECK(ply.properties == std::vector<std::string>{"x", "y", "z", "velocity_x", "velocity_y", "velocity_z", "density", "age", "spin_x",
                                                     "spin_y", "spin_z", "ink_1", "ink_2", "ink_3", "radius", "id", "source"});
    for (int c = 0; c < 3; ++c) {
        const std::string axis(1, static_cast<char>('x' + c));
        CHECK(ply.number.at(axis) == component(frame.position, c));
        CHECK(ply.number.at("velocity_" + axis) == component(frame.velocity, c));
        CHECK(ply.number.at("spin_" + axis) == component(frame.vector.at("spin"), c));
        CHECK(ply.number.at("ink_" + std::to_string(c + 1)) == component(frame.vector.at("ink"), c));
    }
    CHECK(ply.number.at("density") == frame.scalar.at("density"));
    CHECK(ply.number.at("radius") == std::vector<float>(600, 0.05f));
    CHECK(ply.whole.at("id") == frame.whole.at("id"));
    CHECK_FALSE(ply.has_faces);
    CHECK(ply.header.find("comment Whorl frame 12 time 0.458333333 s spacing 0.1") != std::string::npos);
    CHECK(ply.header.find("comment unit of velocity: m/s\n") != std::string::npos);
    CHECK_THROWS_AS(write_ply(folder / "missing" / "a.ply", frame, particle_attributes(frame)), EnvironmentError);
}

TEST_CASE("a PLY of a mesh contains normals, fluid values and triangles, and an empty one has 0 faces", "[export]") {
    const test::ScratchFolder folder;
    TriangleMesh mesh = test::tetrahedron();
    VertexFields fields;
    fields.vector["velocity"] = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}, {1, 1, 1}};
    fields.scalar["viscosity"] = {1, 2, 3, 4};
    write_ply(folder / "a.ply", {}, vertex_attributes(mesh, fields), &mesh.triangle);
    const test::Ply ply = test::read_ply(folder / "a.ply");
    CHECK(ply.properties ==
          std::vector<std::string>{"x", "y", "z", "nx", "ny", "nz", "velocity_x", "velocity_y", "velocity_z", "viscosity"});
    CHECK(ply.number.at("y") == component(mesh.position, 1));
    CHECK(ply.number.at("nz") == component(mesh.normal, 2));
    CHECK(ply.number.at("velocity_x") == component(fields.vector.at("velocity"), 0));
    CHECK(ply.number.at("viscosity") == fields.scalar.at("viscosity"));
    CHECK(ply.face == mesh.triangle);

    mesh = {}, fields.vector["velocity"].clear(), fields.scalar["viscosity"].clear();
    write_ply(folder / "none.ply", {}, vertex_attributes(mesh, fields), &mesh.triangle);
    CHECK(test::read_ply(folder / "none.ply").has_faces);
}

TEST_CASE("VTK files store points and meshes bit-identically, with units in the arrays' names", "[export]") {
    const test::ScratchFolder folder;
    const Frame frame = some_frame();
    write_vtp(folder / "points.vtp", frame.time, particle_attributes(frame));
    const test::Vtk points = test::read_vtk(folder / "points.vtp");
    CHECK(points.number.at("position [m]") == flat(frame.position));
    CHECK(points.number.at("velocity [m/s]") == flat(frame.velocity));
    CHECK(points.number.at("density [kg/m^3]") == frame.scalar.at("density"));
    CHECK(points.whole.at("id") == frame.whole.at("id"));
    CHECK(points.whole.at("connectivity").at(599) == 599);
    CHECK(points.whole.at("offsets").at(599) == 600);
    CHECK(points.number.count("grain") == 0);
    CHECK(points.text.find("Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">0.4583333333333333") != std::string::npos);

    const TriangleMesh mesh = test::tetrahedron();
    write_vtp(folder / "mesh.vtp", 0, vertex_attributes(mesh, {}), &mesh.triangle);
    const test::Vtk surface = test::read_vtk(folder / "mesh.vtp");
    CHECK(surface.number.at("position [m]") == flat(mesh.position));
    CHECK(surface.whole.at("connectivity") == std::vector<std::int32_t>{0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2});
    CHECK(surface.whole.at("offsets") == std::vector<std::int32_t>{3, 6, 9, 12});

    write_pvd(folder / "a.pvd", {{0, "points", "a.1.vtp"}, {0, "mesh", "b.1.vtp"}, {0.1, "points", "a & b.vtp"}});
    CHECK(read_whole(folder / "a.pvd")
              .find("<DataSet timestep=\"0.10000000000000001\" part=\"0\" name=\"points\" file=\"a &amp; b.vtp\"/>\n") !=
          std::string::npos);
}

TEST_CASE("a VTK grid stores the flow at its nodes, and a periodic axis repeats its first node", "[export]") {
    const test::ScratchFolder folder;
    Frame frame;
    frame.spacing = 0.1f, frame.dimensions = 2;
    frame.periodic = {true, false, false};
    frame.domain_max = Vec3f(1, 1, 0);
    for (int i = 0; i < 10; ++i)
        for (int j = 0; j < 10; ++j) {
            frame.position.push_back(0.1f * Vec3f(static_cast<float>(i) + 0.5f, static_cast<float>(j) + 0.5f, 0));
            frame.velocity.push_back(Vec3f(1, -2, 0));
            frame.scalar["pressure"].push_back(static_cast<float>(i));
            for (const char* name : {"density", "age"}) frame.scalar[name].push_back(7);
            frame.vector["vorticity"].push_back(Vec3f(0, 0, 5));  // more than fits into one pass over the particles
        }
    write_vti(folder / "a.vti", frame, particle_attributes(frame));
    const test::Vtk grid = test::read_vtk(folder / "a.vti");
    CHECK(grid.text.find("WholeExtent=\"0 20 0 ") != std::string::npos);  // half a spacing from node to node, and one node more
    CHECK(grid.text.find(" 0 0\" Origin=\"0 ") != std::string::npos);     // one layer
    const std::vector<float>&velocity = grid.number.at("velocity [m/s]"), &pressure = grid.number.at("pressure [Pa]"),
          &cover = grid.number.at("cover"), &vorticity = grid.number.at("vorticity [1/s]");
    REQUIRE(velocity.size() == 3 * cover.size());
    const std::size_t row = 21, middle = cover.size() / row / 2;
    for (std::size_t i = 0; i < row; ++i) {
        const std::size_t node = middle * row + i;
        CHECK(cover[node] > 0.6f);  // mean 1 over the sites of a lattice
        CHECK(velocity[3 * node + 1] == Approx(-2));
        CHECK(vorticity[3 * node + 2] == Approx(5));
    }
    CHECK(pressure[middle * row] == pressure[middle * row + row - 1]);
    CHECK(pressure[middle * row + 10] == Approx(4.5).margin(0.1));  // x = 0.5: between the columns 4 and 5
}

}  // namespace tables_test
