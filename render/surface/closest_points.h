#pragma once
/// Nearest points of a mesh for the voxels around it.
#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <memory>

#include "render/surface/surface.h"

namespace whorl::voxels {

/// Eight numbers, one per voxel of a row.
using Lanes = float __attribute__((vector_size(32)));
using LaneMask = decltype(Lanes() < Lanes());
constexpr int lanes = sizeof(Lanes) / sizeof(float);
constexpr Lanes counted = {0, 1, 2, 3, 4, 5, 6, 7};
constexpr float infinity = std::numeric_limits<float>::infinity();

inline Lanes load(const float* from) {
    Lanes v;
    std::memcpy(&v, from, sizeof v);
    return v;
}
inline void store(float* to, const Lanes& v) { std::memcpy(to, &v, sizeof v); }
inline bool any(const LaneMask& mask) {
    std::array<std::uint64_t, 4> bits;
    std::memcpy(bits.data(), &mask, sizeof bits);
    return (bits[0] | bits[1] | bits[2] | bits[3]) != 0;
}
inline Lanes absolute(const Lanes& v) { return v < 0.0f ? -v : v; }

/// Nearest point of the surface found for each voxel, and its squared distance. Rows are padded by a few voxels at infinite distance, so
/// that eight voxels can be read from any voxel of a row.
class Closest {
public:
    explicit Closest(const Volume& e)
        : row_((e.nx + lanes - 1) / lanes * lanes + lanes), plane_(row_ * e.ny), count_(plane_ * e.nz),
          all_(new float[4 * count_ + 2 * lanes]), x(all_.get() + lanes), y(x + count_), z(y + count_), distance2(z + count_) {
        std::fill(all_.get(), x, infinity);
        std::fill(distance2 + count_, distance2 + count_ + lanes, infinity);
    }
    std::size_t row() const { return row_; }
    std::size_t plane() const { return plane_; }
    std::size_t index(int i, int j, int k) const { return plane_ * k + row_ * j + i; }
    /// Forgets the points of the planes k <= plane < end.
    void clear(int k, int end) {
        for (float* v : {x, y, z, distance2}) std::fill(v + plane_ * k, v + plane_ * end, infinity);
    }

private:
    std::size_t row_, plane_, count_;
    std::unique_ptr<float[]> all_;

public:
    float *x, *y, *z, *distance2;
};

/// Exact closest points of all voxels within `margin` of the surface. The nearest triangle decides on which side of the surface a voxel is.
/// If several triangles share the nearest point (on an edge or a corner), the one that faces the voxel most squarely decides. Voxels
/// without a near triangle are on the same side as the voxel before them in their row. Each row begins and ends outside.
/// @param side set for each voxel: -1 inside, 1 outside
void near_surface(const TriangleMesh& mesh, const Volume& e, float margin, Closest& closest, std::vector<std::int8_t>& side);

}  // namespace whorl::voxels
