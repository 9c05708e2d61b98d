#include <catch2/catch.hpp>
#include <fstream>
#include <sstream>

#include "render/export/attributes.h"
#include "tests/support/exported.h"
#include "tests/support/scratch.h"

using namespace whorl;

TEST_CASE("an OBJ mesh reads back to the same numbers", "[export]") {
    test::ScratchFolder folder;
    const TriangleMesh mesh = test::tetrahedron();
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
