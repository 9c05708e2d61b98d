// OpenVDB files of a frame.
#include <cmath>

#include "engine/core/errors.h"
#include "engine/core/parallel.h"
#include "engine/core/whole_file.h"
#include "render/surface/colour_grid_tree.h"
#include "render/surface/distance.h"
#include "render/surface/surface.h"

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
    const Volume v = distance_volume(mesh, voxel, level_set_band);
    const float edge = v.voxel > 0 ? v.voxel : voxel, background = static_cast<float>(level_set_band) * edge;
    auto grid = openvdb::FloatGrid::create(background);
    grid->setGridClass(openvdb::GRID_LEVEL_SET);
    describe(*grid, "surface", edge, v.origin);
    auto to = grid->getAccessor();
    for (int i = 0; i < v.nx; ++i)
        for (int j = 0; j < v.ny; ++j)
            for (int k = 0; k < v.nz; ++k) {
                const float value = v.value[(static_cast<std::size_t>(k) * v.ny + j) * v.nx + i];
                if (std::abs(value) < background) to.setValueOn({i, j, k}, value);
                else if (value < 0) to.setValueOff({i, j, k}, -background);
            }
    return grid;
}

// Colour and velocity at the nodes that the fluid fills at least in part:  v(x) = sum_j V_j W v_j / sum_j V_j W.
void sample(const ColourField& field, const ColourGrid& colours, const std::vector<Vec3f>& velocity, const std::vector<Index>& original,
            openvdb::FloatGrid& density, openvdb::Vec3SGrid& velocities) {
    constexpr int edge = ColourBlock::edge;
    std::vector<std::pair<openvdb::FloatTree::LeafNodeType*, openvdb::Vec3STree::LeafNodeType*>> leaves;
    for (const ColourBlock& block : colours.blocks()) {
        const openvdb::Coord origin(block.origin[0], block.origin[1], block.origin[2]);
        leaves.emplace_back(density.tree().touchLeaf(origin), velocities.tree().touchLeaf(origin));
    }
    const bool known = !velocity.empty();
    parallel_tasks(static_cast<Index>(leaves.size()), [&](Index b) {
        thread_local LocalField local;
        const ColourBlock& block = colours.blocks()[b];
        const float voxel = colours.voxel();
        const Vec3f low =
            voxel * Vec3f(static_cast<float>(block.origin[0]), static_cast<float>(block.origin[1]), static_cast<float>(block.origin[2]));
        local.gather(field, low, low.array() + voxel * (edge - 1));
        for (openvdb::Index n = 0; n < edge * edge * edge; ++n) {
            if (block.value[n] < 0.05f) continue;
            leaves[b].first->setValueOn(n, std::min(1.0f, block.value[n]));
            if (!known || local.x.empty()) continue;
            const Vec3f x = low + voxel * Vec3f(static_cast<float>(n >> 6), static_cast<float>(n >> 3 & 7), static_cast<float>(n & 7));
            Vec3f sum = Vec3f::Zero();
            float weight = 0;
            for (std::size_t j = 0; j < local.x.size(); ++j) {
                const float t = std::max(0.0f, 1 - local.inverse_R2[j] * (x - Vec3f(local.x[j], local.y[j], local.z[j])).squaredNorm());
                const float w = local.height[j] * t * t * t;
                weight += w;
                sum += w * velocity[original.empty() ? local.original[j] : original[local.original[j]]];
            }
            const Vec3f mean = sum / std::max(weight, 1e-6f);
            leaves[b].second->setValueOn(n, {mean.x(), mean.y(), mean.z()});
        }
    });
}

}  // namespace

void write_vdb(const std::filesystem::path& file, const Frame& frame, const SurfaceOptions& options) {
    prepare_openvdb();
    const auto voxel = static_cast<float>(options.voxel * frame.spacing);
    SurfaceOptions mesh_only = options;
    mesh_only.distance = false;
    const Cut cut = cut_of(frame);
    const Ghosted ghosted = with_ghosts(frame, static_cast<float>(2 * options.radius * frame.spacing));
    const ColourField field(cut.any() ? ghosted.position : frame.position, frame.spacing, options.radius);
    const ColourGrid colours(field, voxel, cut, static_cast<float>(options.iso));

    auto density = openvdb::FloatGrid::create(0);
    density->setGridClass(openvdb::GRID_FOG_VOLUME);
    describe(*density, "density", voxel);
    auto velocity = openvdb::Vec3SGrid::create();
    velocity->setVectorType(openvdb::VEC_CONTRAVARIANT_RELATIVE);
    describe(*velocity, "velocity", voxel);
    sample(field, colours, frame.velocity, ghosted.original, *density, *velocity);
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
