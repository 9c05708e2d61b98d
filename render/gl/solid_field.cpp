#include "render/gl/solid_field.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/core/parallel.h"
#include "render/gl/setup.h"
#include "render/surface/rounded_mesh.h"
#include "render/surface/surface.h"

namespace whorl {
namespace {

constexpr int own_voxels = 64, world_voxels = 96, small_world_voxels = 64, glass_voxels = 128, most_glass_voxels = 192;
constexpr float off_glass = 1.0f / 150;  // of a mesh of glass [voxels]: with wider facets, outlines seen through the glass have teeth

/// Edge of a voxel: `usual` voxels along the longest side, and at least four across the thinnest body, as far as `most`^3 voxels in all
/// allow.
float voxel_edge(const Vec3f& size, float thinnest, int usual, int most) {
    const auto in_all = static_cast<float>(most * most * most);
    const float longest = std::max(size.maxCoeff(), 1e-6f), fine = std::max(thinnest / 4, longest / 512);
    return std::min(longest / static_cast<float>(usual), std::max(fine, std::cbrt(size.prod() / in_all)));
}

/// least[n] = min(least[n], distance of v at place + n*step) [m] for each sample n of a row; place and step are in voxels of v. Outside the
/// volume the distance to its edge is added. Not inlined, and `least` overlaps nothing else: only then does the compiler vectorise the
/// loop.
[[gnu::noinline]] void lower_row(const Volume& v, const Vec3f& place, const Vec3f& step, float* __restrict least, int count) {
    const float* value = v.value.data();
    const int along_y = v.nx, along_z = v.nx * v.ny;
    const float last_x = static_cast<float>(v.nx - 1), last_y = static_cast<float>(v.ny - 1), last_z = static_cast<float>(v.nz - 1);
    for (int n = 0; n < count; ++n) {
        const float at = static_cast<float>(n), px = place.x() + at * step.x(), py = place.y() + at * step.y(),
                    pz = place.z() + at * step.z();
        const float x = std::min(std::max(px, 0.0f), last_x), y = std::min(std::max(py, 0.0f), last_y),
                    z = std::min(std::max(pz, 0.0f), last_z);
        const float ox = px - x, oy = py - y, oz = pz - z;
        const int i = static_cast<int>(std::min(x, last_x - 1)), j = static_cast<int>(std::min(y, last_y - 1)),
                  k = static_cast<int>(std::min(z, last_z - 1));
        const float sx = x - static_cast<float>(i), sy = y - static_cast<float>(j), sz = z - static_cast<float>(k);
        const int c = i + along_y * j + along_z * k;
        const auto row = [&](int r) { return value[r] + sx * (value[r + 1] - value[r]); };
        const float low = row(c) + sy * (row(c + along_y) - row(c)),
                    high = row(c + along_z) + sy * (row(c + along_z + along_y) - row(c + along_z));
        least[n] = std::min(least[n], low + sz * (high - low) + v.voxel * std::sqrt(ox * ox + oy * oy + oz * oz));
    }
}

/// Signed distance in the mesh's own coordinates; the band covers the whole volume.
Volume own_field(const TriangleMesh& mesh, float voxel) {
    const Bounds bounds = bounds_of(mesh.position);
    return distance_volume(mesh, voxel, static_cast<int>(4 * (bounds.high - bounds.low).maxCoeff() / voxel) + 1);
}

/// Twice the volume over the area: the thickness of walls [m].
float mean_thickness(const TriangleMesh& mesh) {
    double area = 0;
    for (const auto& [a, b, c] : mesh.triangle)
        area += (mesh.position[b] - mesh.position[a]).cross(mesh.position[c] - mesh.position[a]).cast<double>().norm() / 2;
    return static_cast<float>(2 * volume_of(mesh) / std::max(area, 1e-30));
}

Volume own_solid_field(const TriangleMesh& mesh) {
    const Bounds bounds = bounds_of(mesh.position);
    const Vec3f size = bounds.high - bounds.low;
    return own_field(mesh, voxel_edge(size, size.minCoeff(), own_voxels, world_voxels));
}

/// Of glass: its walls are four voxels thick if they can be, or their two sides would disturb each other.
Volume own_glass_field(const TriangleMesh& mesh) {
    const Bounds bounds = bounds_of(mesh.position);
    const Vec3f size = bounds.high - bounds.low;
    const float voxel = voxel_edge(size, std::min(mean_thickness(mesh), size.minCoeff()), glass_voxels, most_glass_voxels);
    return own_field(rounded(mesh, off_glass * voxel), voxel);
}

}  // namespace

SolidField::SolidField(int height, bool glass)
    : glass_(glass), voxels_(glass          ? glass_voxels
                             : height < 480 ? small_world_voxels
                                            : world_voxels) {}

Volume SolidField::all_placed(const Vec3f& low, const Vec3f& high, int most) const {
    Volume all;
    all.voxel = std::max((high - low).maxCoeff(), 1e-6f) / static_cast<float>(most - 5);
    all.origin = low - Vec3f::Constant(2 * all.voxel);
    const Eigen::Vector3i count = ((high - low) / all.voxel).array().ceil().cast<int>() + 5;
    all.nx = count.x(), all.ny = count.y(), all.nz = count.z();
    const auto channels = static_cast<std::size_t>(channels_), count_x = static_cast<std::size_t>(all.nx);
    all.value.resize(all.count() * channels);
    parallel_for(all.ny * all.nz, [&](Index r) {
        std::vector<float> rows(channels * count_x, 1e4f);  // half precision has no 1e6
        const Vec3f first = all.origin + all.voxel * Vec3f(0, static_cast<float>(r % all.ny), static_cast<float>(r / all.ny));
        for (const Placed& p : placed_) {
            const Volume& v = own_.at(p.mesh);
            const Mat3f into = p.rotation.transpose() / v.voxel;
            lower_row(v, into * (first - p.translation) - v.origin / v.voxel, into.col(0) * all.voxel,
                      rows.data() + static_cast<std::size_t>(p.channel) * count_x, all.nx);
        }
        for (std::size_t c = 0; c < channels; ++c)
            for (std::size_t i = 0; i < count_x; ++i) all.value[(r * count_x + i) * channels + c] = rows[c * count_x + i];
    });
    return all;
}

void SolidField::fill(const std::vector<FrameSolid>& solids) {
    std::vector<const FrameSolid*> opaque;
    for (const FrameSolid& solid : solids)
        if (solid.mesh && !solid.mesh->triangle.empty() && !solid.container && !is_level_ground(solid) && !is_glass(solid))
            opaque.push_back(&solid);
    fill(opaque, std::vector<int>(opaque.size(), 0), 1);
}

void SolidField::fill(const std::vector<const FrameSolid*>& solids, const std::vector<int>& channel, int channels) {
    std::vector<Placed> now;
    Bounds bounds;
    float thinnest = std::numeric_limits<float>::max();
    for (const FrameSolid* solid : solids) {
        if (now.empty()) turn_ = solid->rotation, move_ = solid->translation;
        FrameSolid seen = *solid;  // relative to the first solid
        if (now.empty()) seen.rotation = Mat3f::Identity(), seen.translation = Vec3f::Zero();
        else seen.rotation = turn_.transpose() * solid->rotation, seen.translation = turn_.transpose() * (solid->translation - move_);
        now.push_back({seen.mesh, seen.rotation, seen.translation, channel[now.size()]});
        bounds.add(bounds_of(seen));
        const Bounds own = bounds_of(solid->mesh->position);
        thinnest = std::min(thinnest, (own.high - own.low).minCoeff());
    }
    channels_ = channels;
    if (now == placed_) return;
    placed_ = std::move(now);
    empty_ = placed_.empty();
    if (empty_) return;

    std::erase_if(own_, [&](const auto& known) {
        return std::none_of(placed_.begin(), placed_.end(), [&](const Placed& p) { return p.mesh == known.first; });
    });
    for (const Placed& p : placed_)
        if (const auto [own, is_new] = own_.try_emplace(p.mesh); is_new)
            own->second = glass_ ? own_glass_field(*p.mesh) : own_solid_field(*p.mesh);
    const Vec3f size = bounds.high - bounds.low;
    // Among others a glass keeps the resolution that it has alone, since its walls are thinner than its bounds.
    float fine = thinnest;
    if (glass_)
        for (const auto& [mesh, own] : own_) fine = std::min(fine, 4 * own.voxel);
    const float voxel = voxel_edge(size, fine, voxels_ - 5, glass_ ? most_glass_voxels : voxels_);
    const Volume all = all_placed(bounds.low, bounds.high, static_cast<int>(std::lround(size.maxCoeff() / voxel)) + 5);
    origin_ = all.origin, voxel_ = all.voxel;
    size_ = Vec3f(static_cast<float>(all.nx), static_cast<float>(all.ny), static_cast<float>(all.nz));
    gl::fill_3d(texture_, all.nx, all.ny, all.nz, all.value.data(), channels_);
}

void SolidField::bind(gl::Program& program, int unit) const {
    const std::string of = glass_ ? "glass" : "solid";
    program.set(("has_" + of + "_field").c_str(), empty_ ? 0 : 1);
    program.texture((of + "_field").c_str(), unit, GL_TEXTURE_3D, texture_.id());
    // The position x is voxel solid_turn x + solid_move of the field.
    program.set((of + "_turn").c_str(), Mat3f(turn_.transpose() / voxel_));
    program.set((of + "_move").c_str(), Vec3f(-(turn_.transpose() * move_ + origin_) / voxel_));
    program.set((of + "_voxel").c_str(), voxel_);
    program.set((of + "_size").c_str(), size_);
}

}  // namespace whorl
