#include "render/surface/mesh_export.h"

#include <catch2/catch.hpp>
#include <fstream>
#include <sstream>

#include "tests/support/scratch.h"

using namespace whorl;

namespace {

TriangleMesh tetrahedron() {
    TriangleMesh mesh;
    mesh.position = {{0, 0, 0}, {1, 0, 0}, {0, 1.25f, 0}, {0, 0, 1e-3f}};
    mesh.normal = {{-1, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    mesh.triangle = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
    return mesh;
}

}  // namespace

TEST_CASE("a PLY mesh holds the vertices, normals and triangles", "[surface]") {
    test::ScratchFolder folder;
    const TriangleMesh mesh = tetrahedron();
    write_ply_mesh(folder / "a.ply", mesh);
    std::ifstream in(folder / "a.ply", std::ios::binary);
    std::string line, header;
    while (std::getline(in, line) && line != "end_header") header += line + "\n";
    REQUIRE(header.find("format binary_little_endian 1.0\n") != std::string::npos);
    REQUIRE(header.find("element vertex 4\n") != std::string::npos);
    REQUIRE(header.find("element face 4\nproperty list uchar uint vertex_indices\n") != std::string::npos);
    for (std::size_t v = 0; v < 4; ++v) {
        float row[6];
        in.read(reinterpret_cast<char*>(row), sizeof row);
        REQUIRE(Vec3f(row[0], row[1], row[2]) == mesh.position[v]);
        REQUIRE(Vec3f(row[3], row[4], row[5]) == mesh.normal[v]);
    }
    for (const auto& t : mesh.triangle) {
        std::array<std::uint32_t, 3> corner{};
        REQUIRE(in.get() == 3);
        in.read(reinterpret_cast<char*>(corner.data()), sizeof corner);
        REQUIRE(corner == t);
    }
    REQUIRE(in.get() == std::ifstream::traits_type::eof());
}

TEST_CASE("an OBJ mesh reads back to the same numbers", "[surface]") {
    test::ScratchFolder folder;
    const TriangleMesh mesh = tetrahedron();
    write_obj_mesh(folder / "a.obj", mesh);
    std::ifstream in(folder / "a.obj");
    TriangleMesh back;
    for (std::string line; std::getline(in, line);) {
        std::istringstream words(line);
        std::string kind;
        words >> kind;
        Vec3f p;
        if (kind == "v" && words >> p.x() >> p.y() >> p.z()) back.position.push_back(p);
        if (kind == "vn" && words >> p.x() >> p.y() >> p.z()) back.normal.push_back(p);
        if (kind == "f") {
            std::array<std::uint32_t, 3> t{};
            for (std::uint32_t& v : t) {
                std::string corner;
                words >> corner;
                v = static_cast<std::uint32_t>(std::stoul(corner)) - 1;
            }
            back.triangle.push_back(t);
        }
    }
    REQUIRE(back.position == mesh.position);
    REQUIRE(back.normal == mesh.normal);
    REQUIRE(back.triangle == mesh.triangle);
}
