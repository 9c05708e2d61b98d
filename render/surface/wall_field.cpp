#include "render/surface/wall_field.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "render/surface/surface.h"

namespace whorl {
namespace {

constexpr float wall_voxel = 0.5f;  // spacings
constexpr int wall_band = 14;       // voxels; a block of the colour field and the kernel's reach
constexpr float near_wall = 0.25f;  // distance below which a point is on a wall [voxels]

}  // namespace

WallField::WallField(const FrameSolid& solid, float spacing) : rotation_(solid.rotation), translation_(solid.translation) {
    Volume volume = distance_volume(*solid.mesh, wall_voxel * spacing, wall_band);
    origin_ = volume.origin, voxel_ = volume.voxel;
    size_ = {volume.nx, volume.ny, volume.nz};
    value_ = std::move(volume.value);
}

WallField::Sample WallField::sample(const Vec3f& x) const {
    const Vec3f p = (rotation_.transpose() * (x - translation_) - origin_) / voxel_;
    std::array<int, 3> cell{};
    Vec3f part, beyond;
    for (int a = 0; a < 3; ++a) {
        const float inside = std::clamp(p[a], 0.0f, static_cast<float>(size_[a] - 1));
        cell[a] = std::min(static_cast<int>(inside), size_[a] - 2);
        part[a] = inside - static_cast<float>(cell[a]), beyond[a] = p[a] - inside;
    }
    const int along_y = size_[0], along_z = size_[0] * size_[1];
    const float* const c = value_.data() + cell[0] + along_y * cell[1] + along_z * cell[2];
    const auto mix = [](float a, float b, float t) { return a + t * (b - a); };
    // Values on the edges along x, then on the faces.
    const float low_low = mix(c[0], c[1], part[0]), high_low = mix(c[along_y], c[along_y + 1], part[0]);
    const float low_high = mix(c[along_z], c[along_z + 1], part[0]),
                high_high = mix(c[along_z + along_y], c[along_z + along_y + 1], part[0]);
    const float low = mix(low_low, high_low, part[1]), high = mix(low_high, high_high, part[1]);
    Vec3f gradient;
    gradient[0] = mix(mix(c[1] - c[0], c[along_y + 1] - c[along_y], part[1]),
                      mix(c[along_z + 1] - c[along_z], c[along_z + along_y + 1] - c[along_z + along_y], part[1]), part[2]);
    gradient[1] = mix(high_low - low_low, high_high - low_high, part[2]);
    gradient[2] = high - low;
    return {mix(low, high, part[2]) + voxel_ * beyond.norm(), gradient / voxel_ + beyond};
}

float WallField::distance(const Vec3f& x) const { return sample(x).distance; }

CutSide WallField::side(const Vec3f& x) const {
    const Sample here = sample(x);
    const float slope = here.gradient.norm();
    const Vec3f inward = slope > 1e-3f ? Vec3f(rotation_ * here.gradient / slope) : Vec3f(Vec3f::UnitY());
    return {inward, inward.dot(x) - here.distance, true};
}

void WallField::add_sides(const Vec3f& x, float reach, std::vector<CutSide>& sides) const {
    const CutSide first = side(x);
    if (first.inside(x) >= reach) return;
    const std::size_t begin = sides.size();
    sides.push_back(first);
    const Vec3f right = first.inward.unitOrthogonal(), up = first.inward.cross(right);
    for (const float way : {2 * voxel_, reach}) {
        if (way < voxel_) continue;
        for (const auto& [a, b] : {std::pair(1.0f, 0.0f),
                                   {0.7f, 0.7f},
                                   {0.0f, 1.0f},
                                   {-0.7f, 0.7f},
                                   {-1.0f, 0.0f},
                                   {-0.7f, -0.7f},
                                   {0.0f, -1.0f},
                                   {0.7f, -0.7f}}) {
            const CutSide other = side(x + way * (a * right + b * up));
            const float inside = other.inside(x);
            if (inside < -near_wall * voxel_ || inside >= reach) continue;
            if (std::any_of(sides.begin() + static_cast<std::ptrdiff_t>(begin), sides.end(),
                            [&](const CutSide& s) { return !are_across(s, other); }))
                continue;
            // The plane ends where the wall ends.
            if (std::abs(distance(x - inside * other.inward)) < near_wall * voxel_) sides.push_back(other);
        }
    }
}

}  // namespace whorl
