#include "render/surface/distance.h"

#include <cmath>
#include <limits>

#include "engine/core/parallel.h"
#include "engine/core/triangle.h"

namespace whorl {
namespace {

constexpr double most_voxels = 16e6;

// What a voxel knows of the surface.
struct Closest {
    Vec3f point = Vec3f::Constant(std::numeric_limits<float>::infinity());
    float distance2 = std::numeric_limits<float>::infinity();
};

// The voxels about the mesh, without values.
Volume extent_of(const TriangleMesh& mesh, float voxel) {
    Vec3f low = mesh.position[0], high = low;
    for (const Vec3f& p : mesh.position) low = low.cwiseMin(p), high = high.cwiseMax(p);
    for (;; voxel *= 1.25f) {
        Vec3f origin;
        std::array<int, 3> size{};
        double count = 1;
        for (int a = 0; a < 3; ++a) {
            const double first = std::floor(low[a] / voxel) - 2, last = std::ceil(high[a] / voxel) + 2;
            origin[a] = voxel * static_cast<float>(first);
            size[a] = static_cast<int>(last - first) + 1;
            count *= last - first + 1;
        }
        if (count <= most_voxels) return {origin, voxel, size[0], size[1], size[2], {}};
    }
}

// Triangles by the slabs of voxels along z that they come near.
class Slabs {
public:
    static constexpr int thickness = 4;
    Slabs(const TriangleMesh& mesh, const Volume& extent, float margin) : begin_((extent.nz + thickness - 1) / thickness + 1, 0) {
        const auto range = [&](std::size_t t) {
            float low = std::numeric_limits<float>::max(), high = -low;
            for (std::uint32_t v : mesh.triangle[t]) low = std::min(low, mesh.position[v].z()), high = std::max(high, mesh.position[v].z());
            const int first = static_cast<int>((low - margin - extent.origin.z()) / extent.voxel) / thickness;
            const int last = static_cast<int>((high + margin - extent.origin.z()) / extent.voxel) / thickness;
            return std::pair(std::max(0, first), std::min(count() - 1, last));
        };
        for (std::size_t t = 0; t < mesh.triangle.size(); ++t)
            for (auto [s, last] = range(t); s <= last; ++s) ++begin_[s + 1];
        for (int s = 0; s < count(); ++s) begin_[s + 1] += begin_[s];
        triangle_.resize(begin_.back());
        std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
        for (std::size_t t = 0; t < mesh.triangle.size(); ++t)
            for (auto [s, last] = range(t); s <= last; ++s) triangle_[next[s]++] = static_cast<std::uint32_t>(t);
    }
    int count() const { return static_cast<int>(begin_.size()) - 1; }
    Span<const std::uint32_t> triangles(int slab) const { return {triangle_.data() + begin_[slab], begin_[slab + 1] - begin_[slab]}; }

private:
    std::vector<std::size_t> begin_;
    std::vector<std::uint32_t> triangle_;
};

// Exact closest points of all voxels within `margin` of the surface, and on which side of it they are. The nearest triangle decides; where
// several share the nearest point (an edge, a corner), the one that faces the voxel most squarely does.
void near_surface(const TriangleMesh& mesh, const Volume& e, float margin, std::vector<Closest>& closest, std::vector<std::int8_t>& side) {
    const Slabs slabs(mesh, e, margin);
    parallel_tasks(slabs.count(), [&](Index slab) {
        const int k_begin = slab * Slabs::thickness, k_end = std::min(e.nz, k_begin + Slabs::thickness);
        std::vector<float> squareness(grid_count(e.nx, e.ny, Slabs::thickness), 0.0f);
        for (std::uint32_t t : slabs.triangles(slab)) {
            const Vec3f &a = mesh.position[mesh.triangle[t][0]], &b = mesh.position[mesh.triangle[t][1]],
                        &c = mesh.position[mesh.triangle[t][2]];
            const Vec3f area = (b - a).cross(c - a);
            const float doubled = area.norm();
            if (doubled <= 0) continue;
            const Vec3f normal = area / doubled, middle = (a + b + c) / 3;
            const float round =
                std::sqrt(std::max({(a - middle).squaredNorm(), (b - middle).squaredNorm(), (c - middle).squaredNorm()})) + margin;
            const Vec3f low = (a.cwiseMin(b).cwiseMin(c).array() - margin - e.origin.array()) / e.voxel,
                        high = (a.cwiseMax(b).cwiseMax(c).array() + margin - e.origin.array()) / e.voxel;
            const int i0 = std::max(0, static_cast<int>(std::ceil(low.x()))), i1 = std::min(e.nx - 1, static_cast<int>(high.x()));
            const int j0 = std::max(0, static_cast<int>(std::ceil(low.y()))), j1 = std::min(e.ny - 1, static_cast<int>(high.y()));
            const int k0 = std::max(k_begin, static_cast<int>(std::ceil(low.z()))), k1 = std::min(k_end - 1, static_cast<int>(high.z()));
            for (int k = k0; k <= k1; ++k)
                for (int j = j0; j <= j1; ++j)
                    for (int i = i0; i <= i1; ++i) {
                        const Vec3f p = e.at(i, j, k);
                        const float above = normal.dot(p - a);
                        if (std::abs(above) > margin || (p - middle).squaredNorm() > round * round) continue;
                        const Vec3f q = nearest_on_triangle(p, a, b, c).point;
                        const float distance2 = (p - q).squaredNorm();
                        Closest& best = closest[e.index(i, j, k)];
                        float& square = squareness[grid_index(i, j, k - k_begin, e.nx, e.ny)];
                        const float tie = 1e-5f * e.voxel * e.voxel;
                        // A large triangle's box holds voxels far beside it: which side of its plane they are on means nothing.
                        if (distance2 > margin * margin || distance2 > best.distance2 + tie) continue;
                        const bool nearer = distance2 < best.distance2 - tie;
                        if (nearer || std::abs(above) > square) {
                            square = std::abs(above);
                            side[e.index(i, j, k)] = above < 0 ? -1 : 1;
                        }
                        if (distance2 < best.distance2) best = {q, distance2};
                    }
        }
    });
}

// Blocks of voxels that the band may reach: those with a voxel near the surface, and what is within the band of these.
class Band {
public:
    static constexpr int edge = 8;
    Band(const Volume& e, const std::vector<Closest>& closest, int band) {
        for (int a = 0; a < 3; ++a) count_[a] = (std::array<int, 3>{e.nx, e.ny, e.nz}[a] + edge - 1) / edge;
        inside_.assign(grid_count(count_[0], count_[1], count_[2]), 0);
        parallel_tasks(count_[2], [&](Index c) {
            for (int k = c * edge; k < std::min(e.nz, (c + 1) * edge); ++k)
                for (int j = 0; j < e.ny; ++j)
                    for (int i = 0; i < e.nx; ++i)
                        if (std::isfinite(closest[e.index(i, j, k)].distance2)) inside_[at({i / edge, j / edge, c})] = 1;
        });
        for (int axis : {0, 1, 2}) widen(axis, (band + edge - 1) / edge);
    }
    int count(int axis) const { return count_[axis]; }
    bool holds(const std::array<int, 3>& block) const { return inside_[at(block)] != 0; }

private:
    std::size_t at(const std::array<int, 3>& b) const { return grid_index(b[0], b[1], b[2], count_[0], count_[1]); }
    void widen(int axis, int by) {
        const std::vector<std::int8_t> before = inside_;
        std::array<int, 3> b{};
        for (b[2] = 0; b[2] < count_[2]; ++b[2])
            for (b[1] = 0; b[1] < count_[1]; ++b[1])
                for (b[0] = 0; b[0] < count_[0]; ++b[0]) {
                    if (before[at(b)] == 0) continue;
                    std::array<int, 3> to = b;
                    for (to[axis] = std::max(0, b[axis] - by); to[axis] <= std::min(count_[axis] - 1, b[axis] + by); ++to[axis])
                        inside_[at(to)] = 1;
                }
    }

    std::array<int, 3> count_{};
    std::vector<std::int8_t> inside_;
};

// Carries closest points from plane to plane along one axis, forwards and backwards; each voxel beyond the exact margin asks the nine
// voxels next to it in the plane before. Six such sweeps reach every voxel along a path that hardly leaves the straight one.
void sweep_closest_points(const Volume& e, const Band& band, int axis, float margin, float limit, std::vector<Closest>& closest) {
    const std::array<int, 3> size{e.nx, e.ny, e.nz};
    const std::array<std::size_t, 3> stride{1, grid_index(0, 1, e.nx), grid_index(0, 0, 1, e.nx, e.ny)};
    const int u = (axis + 1) % 3, v = (axis + 2) % 3, n = size[axis];
    std::vector<std::vector<std::array<int, 2>>> blocks(band.count(axis));  // that the band holds, by plane of blocks
    for (int c = 0; c < band.count(axis); ++c)
        for (int bv = 0; bv < band.count(v); ++bv)
            for (int bu = 0; bu < band.count(u); ++bu) {
                std::array<int, 3> block{};
                block[axis] = c, block[u] = bu, block[v] = bv;
                if (band.holds(block)) blocks[c].push_back({bu, bv});
            }
    const auto ask = [&](const std::array<int, 3>& at, std::size_t here, std::size_t before) {
        Closest& best = closest[here];
        if (best.distance2 <= margin * margin || !(closest[before].distance2 < limit * limit)) return;
        const Vec3f x = e.at(at[0], at[1], at[2]);
        for (int dv = at[v] > 0 ? -1 : 0; dv <= (at[v] + 1 < size[v] ? 1 : 0); ++dv)
            for (int du = at[u] > 0 ? -1 : 0; du <= (at[u] + 1 < size[u] ? 1 : 0); ++du) {
                const Closest& other = closest[before + du * stride[u] + dv * stride[v]];
                const float distance2 = (x - other.point).squaredNorm();
                if (distance2 < best.distance2) best = {other.point, distance2};
            }
    };
    constexpr Index together = 16;
    for (int direction : {1, -1})
        for (int s = 1; s < n; ++s) {
            std::array<int, 3> plane{};
            plane[axis] = direction > 0 ? s : n - 1 - s;
            const std::vector<std::array<int, 2>>& held = blocks[plane[axis] / Band::edge];
            const auto count = static_cast<Index>(held.size());
            parallel_tasks((count + together - 1) / together, [&](Index task) {
                std::array<int, 3> at = plane;
                for (Index m = task * together; m < std::min(count, (task + 1) * together); ++m)
                    for (at[v] = held[m][1] * Band::edge; at[v] < std::min(size[v], (held[m][1] + 1) * Band::edge); ++at[v])
                        for (at[u] = held[m][0] * Band::edge; at[u] < std::min(size[u], (held[m][0] + 1) * Band::edge); ++at[u]) {
                            const std::size_t here = e.index(at[0], at[1], at[2]);
                            ask(at, here, direction > 0 ? here - stride[axis] : here + stride[axis]);
                        }
            });
        }
}

// Voxels that no triangle is near are on the side of those before them. All rows begin outside.
void spread_sides(const Volume& e, std::vector<std::int8_t>& side) {
    parallel_for(static_cast<Index>(e.ny) * e.nz, [&](Index row) {
        std::int8_t* const of_row = side.data() + static_cast<std::size_t>(row) * static_cast<std::size_t>(e.nx);
        std::int8_t last = 1;
        for (int i = 0; i < e.nx; ++i)
            if (of_row[i] == 0) of_row[i] = last;
            else last = of_row[i];
    });
}

}  // namespace

Volume distance_volume(const TriangleMesh& mesh, float voxel, int band) {
    if (mesh.triangle.empty()) return {};
    Volume volume = extent_of(mesh, voxel);
    std::vector<Closest> closest(volume.count());
    std::vector<std::int8_t> side(volume.count(), 0);
    // Each cell that the surface crosses has all its corners within sqrt(3) voxels of it: sides never leak through.
    const float margin = 1.75f * volume.voxel, limit = static_cast<float>(band) * volume.voxel;
    near_surface(mesh, volume, margin, closest, side);
    const Band held(volume, closest, band);
    for (int axis : {0, 1, 2}) sweep_closest_points(volume, held, axis, margin, limit + 2 * volume.voxel, closest);
    spread_sides(volume, side);

    volume.value.resize(volume.count());
    parallel_for(static_cast<Index>(volume.count()),
                 [&](Index n) { volume.value[n] = (side[n] < 0 ? -1.0f : 1.0f) * std::min(limit, std::sqrt(closest[n].distance2)); });
    return volume;
}

}  // namespace whorl
