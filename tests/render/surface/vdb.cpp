#include "render/surface/vdb.h"

#include <openvdb/openvdb.h>

#include <catch2/catch.hpp>

#include "engine/core/errors.h"
#include "tests/support/scratch.h"
#include "tests/support/surface_measures.h"

using namespace whorl;

TEST_CASE("a VDB file opens with a level set, a fog and a velocity", "[surface]") {
    test::ScratchFolder folder;
    Frame frame = test::sphere_frame(4, 1);
    frame.velocity.assign(frame.position.size(), Vec3f(1, -2, 0.5f));
    write_vdb(folder / "a.vdb", frame, {});

    openvdb::initialize();
    openvdb::io::File file((folder / "a.vdb").string());
    file.open();
    const auto surface = openvdb::gridPtrCast<openvdb::FloatGrid>(file.readGrid("surface"));
    const auto density = openvdb::gridPtrCast<openvdb::FloatGrid>(file.readGrid("density"));
    const auto velocity = openvdb::gridPtrCast<openvdb::Vec3SGrid>(file.readGrid("velocity"));
    file.close();
    REQUIRE(surface->getGridClass() == openvdb::GRID_LEVEL_SET);
    REQUIRE(density->getGridClass() == openvdb::GRID_FOG_VOLUME);

    const openvdb::Vec3d centre(0.3, 0.1, 0.4), outside(6.3, 0.1, 0.4), edge(4.3, 0.1, 0.4);
    const auto at = [](const auto& grid, const openvdb::Vec3d& x) {
        return grid->tree().getValue(openvdb::Coord::round(grid->worldToIndex(x)));
    };
    REQUIRE(at(surface, centre) == Approx(-1.5));  // the band: three voxels of half a spacing
    REQUIRE(at(surface, outside) == Approx(1.5));
    REQUIRE(std::abs(at(surface, edge)) < 0.45);  // the nearest node is up to half a voxel's diagonal away
    REQUIRE(at(density, centre) > 0.9f);
    REQUIRE(at(density, outside) == 0);
    // One velocity everywhere is itself wherever the fluid is.
    const auto v = at(velocity, centre);
    REQUIRE((v - openvdb::Vec3s(1, -2, 0.5f)).length() < 1e-5);
    REQUIRE_FALSE(std::filesystem::exists(folder / ".a.vdb.part"));
    REQUIRE_THROWS_AS(write_vdb(folder / "missing" / "a.vdb", frame, {}), EnvironmentError);
}
