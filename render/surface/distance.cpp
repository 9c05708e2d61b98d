#include "render/surface/distance.h"

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>

#include "engine/core/parallel.h"

namespace whorl {
namespace {

constexpr double most_voxels = 16e6;

// Eight numbers, one a voxel of a row.
using Lanes = float __attribute__((vector_size(32)));
using LaneMask = decltype(Lanes() < Lanes());
constexpr int lanes = sizeof(Lanes) / sizeof(float);
constexpr Lanes counted = {0, 1, 2, 3, 4, 5, 6, 7};
constexpr float infinity = std::numeric_limits<float>::infinity();

Lanes load(const float* from) {
    Lanes v;
    std::memcpy(&v, from, sizeof v);
    return v;
}
void store(float* to, const Lanes& v) { std::memcpy(to, &v, sizeof v); }
bool any(const LaneMask& mask) {
    std::array<std::uint64_t, 4> bits;
    std::memcpy(bits.data(), &mask, sizeof bits);
    return (bits[0] | bits[1] | bits[2] | bits[3]) != 0;
}
Lanes absolute(const Lanes& v) { return v < 0.0f ? -v : v; }

// What each voxel knows of the surface: the nearest point of it, and the square of the distance. Rows stand apart by a few voxels that are
// infinitely far: any eight from one of a row on are there.
class Closest {
public:
    explicit Closest(const Volume& e)
        : row_((e.nx + lanes - 1) / lanes * lanes + lanes), plane_(row_ * e.ny), count_(plane_ * e.nz), all_(new float[4 * count_ + 2 * lanes]),
          x(all_.get() + lanes), y(x + count_), z(y + count_), distance2(z + count_) {
        std::fill(all_.get(), x, infinity);
        std::fill(distance2 + count_, distance2 + count_ + lanes, infinity);
    }
    std::size_t row() const { return row_; }
    std::size_t plane() const { return plane_; }
    std::size_t index(int i, int j, int k) const { return plane_ * k + row_ * j + i; }
    // No point is known in the planes from k on, before `end`.
    void clear(int k, int end) {
        for (float* v : {x, y, z, distance2}) std::fill(v + plane_ * k, v + plane_ * end, infinity);
    }

private:
    std::size_t row_, plane_, count_;
    std::unique_ptr<float[]> all_;

public:
    float *x, *y, *z, *distance2;
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

// A triangle as the voxels of a row ask it. Places are from its first corner [m].
class NearTriangle {
public:
    // Of each voxel: the triangle's nearest point, the square of the distance to it, and the signed height above the triangle's plane.
    struct Row {
        Lanes x, y, z, distance2, above;
    };

    NearTriangle(const Vec3f& a, const Vec3f& b, const Vec3f& c, const Vec3f& normal)
        : corner_{Vec3f::Zero(), b - a, c - a}, side_{b - a, c - b, a - c}, normal_(normal) {
        for (int m = 0; m < 3; ++m) {
            const float length2 = side_[m].squaredNorm();
            inverse_[m] = length2 > 0 ? 1 / length2 : 0;
            inward_[m] = normal.cross(side_[m]);
        }
    }
    float above(const Vec3f& p) const { return normal_.dot(p); }

    // @param p the row's first voxel @param step from voxel to voxel along x
    Row nearest(const Vec3f& p, float step) const {
        const Lanes x = p.x() + counted * step, none = x - x;
        Row row{none, none, none, none + std::numeric_limits<float>::max(), above(p) + counted * (step * normal_.x())};
        Lanes least_inward = none + std::numeric_limits<float>::max();
        for (int m = 0; m < 3; ++m) {
            const Vec3f &c = corner_[m], &s = side_[m];
            const float y = p.y() - c.y(), z = p.z() - c.z();
            const Lanes from = x - c.x();
            const Lanes inward = from * inward_[m].x() + (inward_[m].y() * y + inward_[m].z() * z);
            least_inward = inward < least_inward ? inward : least_inward;
            Lanes t = (from * s.x() + (s.y() * y + s.z() * z)) * inverse_[m];
            t = t > 0.0f ? t : none;
            t = t < 1.0f ? t : none + 1.0f;
            const Lanes dx = from - t * s.x(), dy = y - t * s.y(), dz = z - t * s.z(), distance2 = dx * dx + dy * dy + dz * dz;
            const auto nearer = distance2 < row.distance2;
            row.x = nearer ? c.x() + t * s.x() : row.x;
            row.y = nearer ? c.y() + t * s.y() : row.y;
            row.z = nearer ? c.z() + t * s.z() : row.z;
            row.distance2 = nearer ? distance2 : row.distance2;
        }
        const auto face = least_inward >= 0.0f;
        row.x = face ? x - row.above * normal_.x() : row.x;
        row.y = face ? p.y() - row.above * normal_.y() : row.y;
        row.z = face ? p.z() - row.above * normal_.z() : row.z;
        row.distance2 = face ? row.above * row.above : row.distance2;
        return row;
    }

private:
    std::array<Vec3f, 3> corner_, side_, inward_;
    std::array<float, 3> inverse_{};
    Vec3f normal_;
};

// Exact closest points of all voxels within `margin` of the surface. The nearest triangle decides on which side of it they are; where several
// share the nearest point (an edge, a corner), the one that faces the voxel most squarely does. Voxels that no triangle is near are on the
// side of those before them in their row; all rows begin outside.
// @param side of each voxel: -1 inside
void near_surface(const TriangleMesh& mesh, const Volume& e, float margin, Closest& closest, std::vector<std::int8_t>& side) {
    const Slabs slabs(mesh, e, margin);
    // Squares of distances that differ by less are equal but for rounding, which large triangles make larger.
    const float tie = 1e-6f * e.voxel * (e.at(e.nx, e.ny, e.nz) - e.origin).norm();
    const float margin2 = margin * margin, in_voxels = 1.0001f * margin / e.voxel;
    parallel_tasks(slabs.count(), [&](Index slab) {
        const int k_begin = slab * Slabs::thickness, k_end = std::min(e.nz, k_begin + Slabs::thickness);
        closest.clear(k_begin, k_end);
        std::vector<float> above(closest.plane() * Slabs::thickness + lanes, 0.0f);  // the plane of the triangle that decides
        for (std::uint32_t t : slabs.triangles(slab)) {
            const Vec3f &a = mesh.position[mesh.triangle[t][0]], &b = mesh.position[mesh.triangle[t][1]],
                        &c = mesh.position[mesh.triangle[t][2]];
            const Vec3f area = (b - a).cross(c - a);
            const float doubled = area.norm();
            if (doubled <= 0) continue;
            const NearTriangle triangle(a, b, c, area / doubled);
            const Vec3f least = a.cwiseMin(b).cwiseMin(c), most = a.cwiseMax(b).cwiseMax(c);
            const Vec3f low = (least.array() - margin - e.origin.array()) / e.voxel,
                        high = (most.array() + margin - e.origin.array()) / e.voxel;
            const int i0 = std::max(0, static_cast<int>(std::ceil(low.x()))), i1 = std::min(e.nx - 1, static_cast<int>(high.x()));
            const int j0 = std::max(0, static_cast<int>(std::ceil(low.y()))), j1 = std::min(e.ny - 1, static_cast<int>(high.y()));
            const int k0 = std::max(k_begin, static_cast<int>(std::ceil(low.z()))), k1 = std::min(k_end - 1, static_cast<int>(high.z()));
            // How far a row is beside the triangle's box along an axis [voxels].
            const auto beside = [&](int n, int axis) {
                const float from_low = low[axis] + margin / e.voxel - static_cast<float>(n),
                            from_high = static_cast<float>(n) - high[axis] + margin / e.voxel;
                return std::max(0.0f, std::max(from_low, from_high));
            };
            for (int k = k0; k <= k1; ++k)
                for (int j = j0; j <= j1; ++j) {
                    const float beside_y = beside(j, 1), beside_z = beside(k, 2);
                    if (beside_y * beside_y + beside_z * beside_z > in_voxels * in_voxels) continue;
                    for (int first = i0; first <= i1; first += lanes) {
                        const int last = std::min(i1, first + lanes - 1);
                        const Vec3f p = e.at(first, j, k) - a;
                        // A large triangle's box holds voxels far beside it, and all of a row may be far above it.
                        const float above_first = triangle.above(p), above_last = triangle.above(e.at(last, j, k) - a);
                        if (std::min(above_first, above_last) > margin || std::max(above_first, above_last) < -margin) continue;
                        const NearTriangle::Row row = triangle.nearest(p, e.voxel);
                        const std::size_t at = closest.index(first, j, k), at_above = closest.index(first, j, k - k_begin);
                        const Lanes best = load(closest.distance2 + at), best_above = load(above.data() + at_above);
                        const auto near = (row.distance2 <= margin2) & (row.distance2 <= best + tie) & (counted <= static_cast<float>(last - first));
                        if (!any(near)) continue;
                        const auto decides = near & ((row.distance2 < best - tie) | (absolute(row.above) > absolute(best_above)));
                        store(above.data() + at_above, decides ? row.above : best_above);
                        const auto nearer = near & (row.distance2 < best);
                        const auto keep = [&](float* of, const Lanes& value) { store(of + at, nearer ? value : load(of + at)); };
                        keep(closest.x, row.x + a.x());
                        keep(closest.y, row.y + a.y());
                        keep(closest.z, row.z + a.z());
                        keep(closest.distance2, row.distance2);
                    }
                }
        }
        for (int k = k_begin; k < k_end; ++k)
            for (int j = 0; j < e.ny; ++j) {
                const float *const distance2 = closest.distance2 + closest.index(0, j, k), *const over = above.data() + closest.index(0, j, k - k_begin);
                std::int8_t* const of_row = side.data() + e.index(0, j, k);
                std::int8_t last = 1;
                for (int i = 0; i < e.nx; ++i) {
                    if (distance2[i] < infinity) last = over[i] < 0 ? -1 : 1;
                    of_row[i] = last;
                }
            }
    });
}

// Blocks of voxels that the band may reach: those with a voxel near the surface, and what is within the band of these.
class Band {
public:
    static constexpr int edge = lanes;
    Band(const Volume& e, const Closest& closest, int band) {
        for (int a = 0; a < 3; ++a) count_[a] = (std::array<int, 3>{e.nx, e.ny, e.nz}[a] + edge - 1) / edge;
        inside_.assign(grid_count(count_[0], count_[1], count_[2]), 0);
        parallel_tasks(count_[2], [&](Index c) {
            for (int k = c * edge; k < std::min(e.nz, (c + 1) * edge); ++k)
                for (int j = 0; j < e.ny; ++j)
                    for (int i = 0; i < e.nx; ++i)
                        if (closest.distance2[closest.index(i, j, k)] < infinity) inside_[at({i / edge, j / edge, c})] = 1;
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
class Sweep {
public:
    Sweep(const Volume& e, const Band& band, int axis, float margin, float limit, Closest& closest)
        : e_(e), band_(band), closest_(closest), axis_(axis), margin2_(margin * margin),
          limit2_(limit * limit), size_{e.nx, e.ny, e.nz}, stride_{1, closest.row(), closest.plane()} {}

    void run() const {
        const int n = size_[axis_];
        std::vector<std::vector<std::array<int, 3>>> blocks(band_.count(axis_));  // that the band holds, by plane of blocks
        std::array<int, 3> b{};
        for (b[2] = 0; b[2] < band_.count(2); ++b[2])
            for (b[1] = 0; b[1] < band_.count(1); ++b[1])
                for (b[0] = 0; b[0] < band_.count(0); ++b[0])
                    if (band_.holds(b)) blocks[b[axis_]].push_back(b);
        constexpr Index together = 16;
        for (int direction : {1, -1})
            for (int s = 1; s < n; ++s) {
                const int plane = direction > 0 ? s : n - 1 - s;
                const std::vector<std::array<int, 3>>& held = blocks[plane / Band::edge];
                const auto count = static_cast<Index>(held.size());
                parallel_tasks((count + together - 1) / together, [&](Index task) {
                    for (Index m = task * together; m < std::min(count, (task + 1) * together); ++m) block(held[m], plane, direction);
                });
            }
    }

private:
    // The voxels of a block that lie in the plane.
    void block(const std::array<int, 3>& b, int plane, int direction) const {
        std::array<int, 3> first{}, end{};
        for (int a = 0; a < 3; ++a) first[a] = b[a] * Band::edge, end[a] = std::min(size_[a], first[a] + Band::edge);
        first[axis_] = plane, end[axis_] = plane + 1;
        std::array<int, 3> at{};
        for (at[2] = first[2]; at[2] < end[2]; ++at[2])
            for (at[1] = first[1]; at[1] < end[1]; ++at[1]) {
                at[0] = first[0];
                if (axis_ != 0) ask_for_row(at, direction);
                else
                    for (; at[0] < end[0]; ++at[0]) ask(at, direction);
            }
    }

    std::size_t before(std::size_t here, int direction) const { return direction > 0 ? here - stride_[axis_] : here + stride_[axis_]; }

    void ask(const std::array<int, 3>& at, int direction) const {
        const std::size_t here = closest_.index(at[0], at[1], at[2]), from = before(here, direction);
        float best = closest_.distance2[here];
        if (best <= margin2_ || !(closest_.distance2[from] < limit2_)) return;
        const Vec3f x = e_.at(at[0], at[1], at[2]);
        const int u = (axis_ + 1) % 3, v = (axis_ + 2) % 3;
        for (int dv = at[v] > 0 ? -1 : 0; dv <= (at[v] + 1 < size_[v] ? 1 : 0); ++dv)
            for (int du = at[u] > 0 ? -1 : 0; du <= (at[u] + 1 < size_[u] ? 1 : 0); ++du) {
                const std::size_t other = from + du * stride_[u] + dv * stride_[v];
                const Vec3f point(closest_.x[other], closest_.y[other], closest_.z[other]);
                const float distance2 = (x - point).squaredNorm();
                if (distance2 < best) {
                    closest_.x[here] = point.x(), closest_.y[here] = point.y(), closest_.z[here] = point.z();
                    closest_.distance2[here] = best = distance2;
                }
            }
    }

    // The same of `lanes` voxels along x.
    void ask_for_row(const std::array<int, 3>& at, int direction) const {
        const std::size_t here = closest_.index(at[0], at[1], at[2]), from = before(here, direction);
        Lanes best = load(closest_.distance2 + here);
        const auto asks = (best > margin2_) & (load(closest_.distance2 + from) < limit2_);
        if (!any(asks)) return;
        const Vec3f first = e_.at(at[0], at[1], at[2]);
        const Lanes x = first.x() + counted * e_.voxel;
        Lanes px = load(closest_.x + here), py = load(closest_.y + here), pz = load(closest_.z + here);
        const int v = 3 - axis_;
        for (int dv = at[v] > 0 ? -1 : 0; dv <= (at[v] + 1 < size_[v] ? 1 : 0); ++dv)
            for (int dx = -1; dx <= 1; ++dx) {
                const std::size_t other = from + dx + dv * stride_[v];
                const Lanes qx = load(closest_.x + other), qy = load(closest_.y + other), qz = load(closest_.z + other);
                const Lanes rx = x - qx, ry = first.y() - qy, rz = first.z() - qz, distance2 = rx * rx + ry * ry + rz * rz;
                const auto nearer = asks & (distance2 < best);
                best = nearer ? distance2 : best;
                px = nearer ? qx : px, py = nearer ? qy : py, pz = nearer ? qz : pz;
            }
        store(closest_.distance2 + here, best);
        store(closest_.x + here, px), store(closest_.y + here, py), store(closest_.z + here, pz);
    }

    const Volume& e_;
    const Band& band_;
    Closest& closest_;
    int axis_;
    float margin2_, limit2_;
    std::array<int, 3> size_;
    std::array<std::size_t, 3> stride_;
};

}  // namespace

Volume distance_volume(const TriangleMesh& mesh, float voxel, int band) {
    if (mesh.triangle.empty()) return {};
    Volume volume = extent_of(mesh, voxel);
    Closest closest(volume);
    std::vector<std::int8_t> side(volume.count());
    // Each cell that the surface crosses has all its corners within sqrt(3) voxels of it: sides never leak through.
    const float margin = 1.75f * volume.voxel, limit = static_cast<float>(band) * volume.voxel;
    near_surface(mesh, volume, margin, closest, side);
    const Band held(volume, closest, band);
    for (int axis : {0, 1, 2}) Sweep(volume, held, axis, margin, limit + 2 * volume.voxel, closest).run();

    volume.value.resize(volume.count());
    parallel_for(volume.ny * volume.nz, [&](Index row) {
        const float* const distance2 = closest.distance2 + closest.row() * row;
        const std::size_t first = static_cast<std::size_t>(row) * static_cast<std::size_t>(volume.nx);
        for (int i = 0; i < volume.nx; ++i)
            volume.value[first + i] = (side[first + i] < 0 ? -1.0f : 1.0f) * std::min(limit, std::sqrt(distance2[i]));
    });
    return volume;
}

}  // namespace whorl
