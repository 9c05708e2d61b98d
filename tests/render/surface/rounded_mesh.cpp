/// Meshes of curved solids, refined along their normals.
#include "render/surface/rounded_mesh.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "engine/geometry/mesh_file.h"
#include "engine/geometry/shape.h"
#include "tests/support/shapes.h"
#include "tests/support/surface_measures.h"

using namespace whorl;

namespace {

/// Largest distance of the triangles' middles from the shape.
float farthest(const TriangleMesh& mesh, const Shape& shape) {
    float most = 0;
    for (const auto& t : mesh.triangle)
        most = std::max(most, std::abs(static_cast<float>(
                                  shape.distance((mesh.position[t[0]] + mesh.position[t[1]] + mesh.position[t[2]]).cast<Real>() / 3))));
    return most;
}

TEST_CASE("a rounded mesh is closed, and four times as near to a vessel or a ring as its facets or as near as wanted", "[surface]") {
    ShapeKeys keys;
    keys.kind = GENERATE("cylinder", "sphere", "torus");
    keys.radius = 1, keys.from = {0, 0, 0}, keys.to = {0, 2, 0}, keys.tube = 0.3, keys.axis = {0, 1, 0};
    if (keys.kind != "torus") keys.open = "top", keys.wall = 0.2, keys.rim = 0.4;
    const std::shared_ptr<const Shape> shape = make_shape(keys);
    const TriangleMesh coarse = shape->mesh(Real(0.1), 0);
    constexpr float off = 3e-4f;
    TriangleMesh fine = rounded(coarse, off);
    const float facets = farthest(coarse, *shape);
    CAPTURE(keys.kind, facets, coarse.triangle.size(), fine.triangle.size());
    CHECK(facets > 5e-4f);
    // The middle of a triangle may be farther away than those of its edges, of which each may be `off` away.
    CHECK(farthest(fine, *shape) < std::max(facets / 4, 2 * off));
    CHECK(fine.normal.size() == fine.position.size());
    weld(fine);
    CHECK(test::topology(fine).manifold);
}

TEST_CASE("a rounded box is the box", "[surface]") {
    const TriangleMesh box = test::box_mesh(Vec3f(0, 0, 0), Vec3f(1, 2, 3));
    CHECK(rounded(box, 1e-5f).triangle == box.triangle);
}

}  // namespace
