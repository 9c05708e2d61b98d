#include "render/gl/solid_field.h"

#include <algorithm>
#include <cmath>

#include "engine/core/parallel.h"
#include "render/gl/setup.h"
#include "render/surface/distance.h"

namespace whorl {
namespace {

constexpr int own_voxels = 64, world_voxels = 96;

float trilinear(const Volume& v, const Vec3f& place) {
    const Eigen::Vector3i n = place.array().floor().cast<int>().max(0).min(Eigen::Array3i(v.nx - 2, v.ny - 2, v.nz - 2));
    const Vec3f s = place - n.cast<float>();
    const float* at = &v.value[(static_cast<std::size_t>(n.z()) * v.ny + n.y()) * v.nx + n.x()];
    const auto row = [&](const float* r) { return r[0] + s.x() * (r[1] - r[0]); };
    const auto sheet = [&](const float* r) { return row(r) + s.y() * (row(r + v.nx) - row(r)); };
    return sheet(at) + s.z() * (sheet(at + static_cast<std::ptrdiff_t>(v.nx) * v.ny) - sheet(at));
}

}  // namespace

Volume union_of(const std::vector<const Volume*>& own, const std::vector<Mat3f>& rotation, const std::vector<Vec3f>& translation, const Vec3f& low,
                const Vec3f& high, int most) {
    Volume all;
    all.voxel = std::max((high - low).maxCoeff(), 1e-6f) / static_cast<float>(most - 5);
    all.origin = low - Vec3f::Constant(2 * all.voxel);
    const Eigen::Vector3i count = ((high - low) / all.voxel).array().ceil().cast<int>() + 5;
    all.nx = count.x(), all.ny = count.y(), all.nz = count.z();
    all.value.resize(static_cast<std::size_t>(all.nx) * all.ny * all.nz);
    parallel_for(static_cast<Index>(all.value.size()), [&](Index n) {
        const Vec3f x = all.origin + all.voxel * Vec3f(static_cast<float>(n % all.nx), static_cast<float>(n / all.nx % all.ny), static_cast<float>(n / all.nx / all.ny));
        float nearest = 1e6f;
        for (std::size_t k = 0; k < own.size(); ++k) {
            const Volume& v = *own[k];
            const Vec3f place = (rotation[k].transpose() * (x - translation[k]) - v.origin) / v.voxel;
            const Vec3f within = place.cwiseMax(0.0f).cwiseMin(Vec3f(static_cast<float>(v.nx - 1), static_cast<float>(v.ny - 1), static_cast<float>(v.nz - 1)));
            nearest = std::min(nearest, trilinear(v, within) + v.voxel * (place - within).norm());
        }
        all.value[static_cast<std::size_t>(n)] = nearest;
    });
    return all;
}

const Volume& SolidField::own_field(const std::shared_ptr<const TriangleMesh>& mesh) {
    for (const auto& [known, volume] : own_)
        if (known == mesh) return volume;
    const Bounds bounds = bounds_of(mesh->position);
    const float voxel = std::max((bounds.high - bounds.low).maxCoeff(), 1e-6f) / own_voxels;
    own_.emplace_back(mesh, distance_volume(*mesh, voxel, 4 * own_voxels));
    return own_.back().second;
}

void SolidField::fill(const std::vector<FrameSolid>& solids) {
    std::vector<Placed> now;
    Bounds bounds;
    for (const FrameSolid& solid : solids) {
        if (!solid.mesh || solid.mesh->triangle.empty() || solid.container || is_level_ground(solid)) continue;
        now.push_back({solid.mesh, solid.rotation, solid.translation});
        bounds.add(bounds_of(solid));
    }
    const auto same = [](const Placed& a, const Placed& b) { return a.mesh == b.mesh && a.rotation == b.rotation && a.translation == b.translation; };
    if (std::equal(now.begin(), now.end(), placed_.begin(), placed_.end(), same)) return;
    placed_ = std::move(now);
    empty_ = placed_.empty();
    if (empty_) return;

    std::erase_if(own_, [&](const auto& known) { return std::none_of(placed_.begin(), placed_.end(), [&](const Placed& p) { return p.mesh == known.first; }); });
    for (const Placed& p : placed_) own_field(p.mesh);
    std::vector<const Volume*> own;
    std::vector<Mat3f> rotation;
    std::vector<Vec3f> translation;
    for (const Placed& p : placed_) own.push_back(&own_field(p.mesh)), rotation.push_back(p.rotation), translation.push_back(p.translation);
    const Volume all = union_of(own, rotation, translation, bounds.low, bounds.high, world_voxels);
    origin_ = all.origin, voxel_ = all.voxel;
    size_ = Vec3f(static_cast<float>(all.nx), static_cast<float>(all.ny), static_cast<float>(all.nz));
    gl::fill_3d(texture_, all.nx, all.ny, all.nz, all.value.data());
}

void SolidField::bind(gl::Program& program, int unit) const {
    program.set("has_solid_field", empty_ ? 0 : 1);
    program.texture("solid_field", unit, GL_TEXTURE_3D, texture_.id());
    program.set("solid_origin", origin_);
    program.set("solid_voxel", voxel_);
    program.set("solid_size", size_);
}

}  // namespace whorl
