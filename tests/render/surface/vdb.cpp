#include "render/surface/vdb.h"

#include <openvdb/openvdb.h>

#include <catch2/catch.hpp>

#include "engine/core/errors.h"
#include "tests/support/scratch.h"
#include "tests/support/surface_measures.h"

using namespace whorl;

TEST_CASE("a VDB file contains a level set, a velocity and a cloud's density with their metadata", "[surface]") {
    test::ScratchFolder folder;
    const Surface surface = build_surface(test::sphere_frame(4, 1), {});
    // Fluid fills the lower half of a grid of cells of three lengths.
    std::vector<float> cover, density;
    std::vector<Vec3f> velocity;
    for (int k = 0; k < 4; ++k)
        for (int j = 0; j < 6; ++j)
            for (int i = 0; i < 10; ++i) {
                cover.push_back(j < 3 ? 1.0f : 0.0f);
                density.push_back(static_cast<float>(i) / 16);
                velocity.push_back(Vec3f(static_cast<float>(i), 0.1f, -2));
            }
    const GridFields fields{Vec3f(1, 2, 3), Vec3f(0.5f, 0.25f, 1), {10, 6, 4}, cover, velocity, density};
    const auto names = test::names_made(folder.path(), [&] { write_vdb(folder / "a.vdb", {7, 0.25, 0.5f}, surface, fields); });
    REQUIRE(names == std::vector<std::string>{".a.vdb.part"});

    openvdb::initialize();
    openvdb::io::File file((folder / "a.vdb").string());
    file.open();
    const auto about = file.getMetadata();
    CHECK(about->metaValue<std::int32_t>("frame") == 7);
    CHECK(about->metaValue<double>("time") == 0.25);
    CHECK(about->metaValue<float>("voxel_size") == 0.5f);
    const auto level_set = openvdb::gridPtrCast<openvdb::FloatGrid>(file.readGrid("surface"));
    const auto fog = openvdb::gridPtrCast<openvdb::FloatGrid>(file.readGrid("density"));
    const auto flow = openvdb::gridPtrCast<openvdb::Vec3SGrid>(file.readGrid("velocity"));
    file.close();
    REQUIRE(level_set->getGridClass() == openvdb::GRID_LEVEL_SET);
    REQUIRE(fog->getGridClass() == openvdb::GRID_FOG_VOLUME);
    CHECK(level_set->metaValue<std::string>("unit") == "m");
    CHECK(flow->metaValue<std::string>("unit") == "m/s");
    CHECK_FALSE(flow->metaValue<bool>("staggered"));

    const openvdb::Vec3d centre(0.3, 0.1, 0.4), outside(6.3, 0.1, 0.4);
    const auto at = [](const auto& grid, const openvdb::Vec3d& x) {
        return grid->tree().getValue(openvdb::Coord::round(grid->worldToIndex(x)));
    };
    REQUIRE(at(level_set, centre) == Approx(-1.5));  // the band: three voxels of half a spacing
    REQUIRE(at(level_set, outside) == Approx(1.5));
    // In the band the distances equal those of the surface's volume bit for bit.
    const Volume& distance = surface.distance;
    for (auto value = level_set->cbeginValueOn(); value; ++value) {
        const openvdb::Coord c = value.getCoord();
        REQUIRE(*value == distance.value[distance.index(c.x(), c.y(), c.z())]);
    }
    // Nodes are at the grid's positions. Half floats represent these numbers exactly, except 0.1.
    CHECK((flow->indexToWorld(openvdb::Coord(2, 1, 3)) - openvdb::Vec3d(2, 2.25, 6)).length() < 1e-6);
    const openvdb::Vec3s u = flow->tree().getValue(openvdb::Coord(9, 2, 3));
    CHECK(u.x() == 9);
    CHECK(u.y() == static_cast<float>(openvdb::math::half(0.1f)));
    CHECK(u.z() == -2);
    CHECK_FALSE(flow->tree().isValueOn(openvdb::Coord(9, 3, 3)));  // no fluid there
    CHECK(fog->tree().getValue(openvdb::Coord(5, 2, 0)) == 5.0f / 16);
    REQUIRE_THROWS_AS(write_vdb(folder / "missing" / "a.vdb", {7, 0.25, 0.5f}, surface, fields), EnvironmentError);
}
