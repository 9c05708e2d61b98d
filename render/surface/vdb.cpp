#include "render/surface/vdb.h"

#include <openvdb/io/Archive.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Activate.h>
#include <openvdb/tools/Dense.h>
#include <tbb/global_control.h>

#include <sstream>

#include "engine/core/atomic_file.h"
#include "engine/core/errors.h"
#include "engine/core/parallel.h"
#include "render/surface/surface.h"

namespace whorl {
namespace {

constexpr int level_set_band = 3;  // voxels; the width that other programs expect

template <class Grid>
void describe(Grid& grid, const char* name, const char* unit, const Vec3f& cell, const Vec3f& origin) {
    grid.setName(name);
    openvdb::Mat4d to_world = openvdb::Mat4d::identity();
    to_world.preScale(openvdb::Vec3d(cell.x(), cell.y(), cell.z()));
    to_world.setTranslation(openvdb::Vec3d(origin.x(), origin.y(), origin.z()));
    grid.setTransform(openvdb::math::Transform::createLinearTransform(to_world));
    grid.insertMeta("unit", openvdb::StringMetadata(unit));
}

openvdb::FloatGrid::Ptr level_set(const Surface& surface, float voxel) {
    Volume own;
    const bool usable = !surface.distance.value.empty() && surface.distance.voxel <= 1.001f * voxel;
    if (!usable) own = distance_volume(surface.mesh, voxel, level_set_band);
    const Volume& v = usable ? surface.distance : own;
    const float cell = v.voxel > 0 ? v.voxel : voxel, background = static_cast<float>(level_set_band) * cell;
    auto grid = openvdb::FloatGrid::create(background);
    grid->setGridClass(openvdb::GRID_LEVEL_SET);
    describe(*grid, "surface", "m", Vec3f::Constant(cell), v.origin);
    if (v.value.empty()) return grid;
    std::vector<float> clamped(v.value.size());
    parallel_for(static_cast<Index>(clamped.size()), [&](Index k) { clamped[k] = std::clamp(v.value[k], -background, background); });
    using Dense = openvdb::tools::Dense<float, openvdb::tools::LayoutXYZ>;
    openvdb::tools::copyFromDense(Dense(openvdb::CoordBBox({0, 0, 0}, {v.nx - 1, v.ny - 1, v.nz - 1}), clamped.data()), *grid, 0.0f);
    openvdb::tools::deactivate(*grid, -background);
    openvdb::tools::pruneLevelSet(grid->tree());
    return grid;
}

/// Calls f(coordinate, node) for the nodes near the fluid.
template <class F>
void each_node(const GridFields& fields, F&& f) {
    std::size_t node = 0;
    for (int k = 0; k < fields.n[2]; ++k)
        for (int j = 0; j < fields.n[1]; ++j)
            for (int i = 0; i < fields.n[0]; ++i, ++node)
                if (fields.cover[node] > 0.02f) f(openvdb::Coord(i, j, k), node);
}

openvdb::Vec3SGrid::Ptr velocity_grid(const GridFields& fields) {
    auto grid = openvdb::Vec3SGrid::create();
    grid->setVectorType(openvdb::VEC_CONTRAVARIANT_RELATIVE);
    grid->setSaveFloatAsHalf(true);
    describe(*grid, "velocity", "m/s", fields.cell, fields.origin);
    grid->insertMeta("staggered", openvdb::BoolMetadata(false));
    auto values = grid->getAccessor();
    each_node(fields, [&](const openvdb::Coord& at, std::size_t node) {
        const Vec3f& u = fields.velocity[node];
        values.setValueOn(at, {u.x(), u.y(), u.z()});
    });
    return grid;
}

openvdb::FloatGrid::Ptr density_grid(const GridFields& fields) {
    auto grid = openvdb::FloatGrid::create(0);
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    grid->setSaveFloatAsHalf(true);
    describe(*grid, "density", "", fields.cell, fields.origin);
    auto values = grid->getAccessor();
    each_node(fields, [&](const openvdb::Coord& at, std::size_t node) {
        if (fields.density[node] > 0) values.setValueOn(at, fields.density[node]);
    });
    return grid;
}

/// A .vdb file in memory, with the offsets that let programs read a single grid. io::File can only write to a disk, and does not report a
/// full one.
struct VdbInMemory : openvdb::io::Archive {
    std::string bytes(const openvdb::GridCPtrVec& grids, const openvdb::MetaMap& about) const {
        std::ostringstream out(std::ios::binary);
        write(out, grids, true, about);
        return std::move(out).str();
    }
};

}  // namespace

void write_vdb(const std::filesystem::path& file, const VdbFile& about, const Surface& surface, const GridFields& fields) {
    WHORL_ASSERT(about.voxel > 0, +std::to_string(about.voxel));
    openvdb::initialize();
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads()));
    openvdb::GridCPtrVec grids{level_set(surface, about.voxel)};
    if (!fields.velocity.empty()) grids.push_back(velocity_grid(fields));
    if (!fields.density.empty()) grids.push_back(density_grid(fields));

    openvdb::MetaMap all;
    all.insertMeta("creator", openvdb::StringMetadata("Whorl"));
    all.insertMeta("frame", openvdb::Int32Metadata(about.frame));
    all.insertMeta("time", openvdb::DoubleMetadata(about.time));
    all.insertMeta("voxel_size", openvdb::FloatMetadata(static_cast<float>(grids[0]->voxelSize()[0])));
    all.insertMeta("units", openvdb::StringMetadata("lengths in m, time in s, y is up; each grid's unit in its own metadata"));
    VdbInMemory archive;
    archive.setCompression((openvdb::io::Archive::hasBloscCompression() ? openvdb::io::COMPRESS_BLOSC : openvdb::io::COMPRESS_ZIP) |
                           openvdb::io::COMPRESS_ACTIVE_MASK);
    write_text(file, archive.bytes(grids, all));
}

}  // namespace whorl
