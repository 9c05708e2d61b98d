#include "render/surface/vdb.h"

#include <openvdb/openvdb.h>
#include <openvdb/tools/Activate.h>
#include <openvdb/tools/Dense.h>
#include <tbb/global_control.h>

#include "engine/core/errors.h"
#include "engine/core/parallel.h"
#include "engine/core/whole_file.h"
#include "render/surface/colour_grid.h"
#include "render/surface/distance.h"

namespace whorl {
namespace {

constexpr int level_set_band = 3;  // voxels, what other programs expect

template <class Grid>
void describe(Grid& grid, const char* name, float voxel, const Vec3f& origin = Vec3f::Zero()) {
    grid.setName(name);
    auto transform = openvdb::math::Transform::createLinearTransform(voxel);
    transform->postTranslate(openvdb::Vec3d(origin.x(), origin.y(), origin.z()));
    grid.setTransform(transform);
}

openvdb::FloatGrid::Ptr level_set(const TriangleMesh& mesh, float voxel) {
    Volume v = distance_volume(mesh, voxel, level_set_band);
    const float cell = v.voxel > 0 ? v.voxel : voxel, background = static_cast<float>(level_set_band) * cell;
    auto grid = openvdb::FloatGrid::create(background);
    grid->setGridClass(openvdb::GRID_LEVEL_SET);
    describe(*grid, "surface", cell, v.origin);
    if (v.value.empty()) return grid;
    using Dense = openvdb::tools::Dense<float, openvdb::tools::LayoutXYZ>;
    openvdb::tools::copyFromDense(Dense(openvdb::CoordBBox({0, 0, 0}, {v.nx - 1, v.ny - 1, v.nz - 1}), v.value.data()), *grid, 0.0f);
    openvdb::tools::deactivate(*grid, -background);
    return grid;
}

// Colour and velocity at the nodes that the fluid fills at least in part.
void sample(const ColourField& field, const ColourGrid& colours, const std::vector<Vec3f>& velocity, openvdb::FloatGrid& density,
            openvdb::Vec3SGrid& velocities) {
    std::vector<std::pair<openvdb::FloatTree::LeafNodeType*, openvdb::Vec3STree::LeafNodeType*>> leaves;
    for (const ColourBlock& block : colours.blocks()) {
        const openvdb::Coord origin(block.origin[0], block.origin[1], block.origin[2]);
        leaves.emplace_back(density.tree().touchLeaf(origin), velocities.tree().touchLeaf(origin));
    }
    parallel_tasks(static_cast<Index>(leaves.size()), [&](Index b) {
        thread_local LocalField local;
        const ColourBlock& block = colours.blocks()[b];
        const float voxel = colours.voxel();
        const Vec3f low = block.low(voxel);
        local.gather(field, low, low.array() + voxel * (block_edge - 1));
        for (openvdb::Index n = 0; n < block_nodes; ++n) {
            if (block.value[n] < 0.05f) continue;
            leaves[b].first->setValueOn(n, std::min(1.0f, block.value[n]));
            if (velocity.empty() || local.x.empty()) continue;
            const Vec3f mean = local.mean(low + voxel * ColourBlock::node(static_cast<int>(n)), velocity);
            leaves[b].second->setValueOn(n, {mean.x(), mean.y(), mean.z()});
        }
    });
}

}  // namespace

void write_vdb(const std::filesystem::path& file, const Frame& frame, const SurfaceOptions& options) {
    openvdb::initialize();
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads()));
    const auto voxel = static_cast<float>(options.voxel * frame.spacing);
    SurfaceOptions mesh_only = options;
    mesh_only.distance = false;
    const Cut cut = cut_of(frame);
    const Ghosted ghosted = with_ghosts(frame, static_cast<float>(2 * options.radius * frame.spacing));
    const ColourField field(cut.any() ? ghosted.position : frame.position, frame.spacing, options.radius);
    const ColourGrid colours(field, voxel, cut, static_cast<float>(options.iso));
    std::vector<Vec3f> velocities = frame.velocity;
    if (!velocities.empty() && !ghosted.original.empty()) {
        velocities.clear();
        for (const Index i : ghosted.original) velocities.push_back(frame.velocity[i]);
    }

    auto density = openvdb::FloatGrid::create(0);
    density->setGridClass(openvdb::GRID_FOG_VOLUME);
    describe(*density, "density", voxel);
    auto velocity = openvdb::Vec3SGrid::create();
    velocity->setVectorType(openvdb::VEC_CONTRAVARIANT_RELATIVE);
    describe(*velocity, "velocity", voxel);
    sample(field, colours, velocities, *density, *velocity);
    const openvdb::GridCPtrVec grids{level_set(build_surface(frame, mesh_only).mesh, voxel), density, velocity};

    WholeFile whole(file);
    try {
        openvdb::io::File out(whole.temporary().string());
        out.write(grids);
        out.close();
    } catch (const openvdb::IoError& error) { throw EnvironmentError("cannot write " + file.string() + ": " + error.what()); }
    whole.commit();
}

}  // namespace whorl
