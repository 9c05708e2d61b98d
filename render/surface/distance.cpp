#include "render/surface/distance.h"

#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "engine/core/parallel.h"

namespace whorl {
namespace {

constexpr double most_voxels = 16e6;

// What each voxel knows of the surface: the nearest point of it, and the square of the distance.
struct Closest {
    std::vector<float> x, y, z, distance2;
    explicit Closest(std::size_t voxels) {
        for (std::vector<float>* v : {&x, &y, &z, &distance2}) v->assign(voxels, std::numeric_limits<float>::infinity());
    }
    void set(std::size_t at, const Vec3f& point, float square) {
        x[at] = point.x(), y[at] = point.y(), z[at] = point.z(), distance2[at] = square;
    }
};

// Eight numbers, one a voxel of a row.
using Lanes = float __attribute__((vector_size(32)));
constexpr int lanes = sizeof(Lanes) / sizeof(float);
constexpr Lanes counted = {0, 1, 2, 3, 4, 5, 6, 7};

Lanes load(const std::vector<float>& from, std::size_t at) {
    Lanes v;
    std::memcpy(&v, from.data() + at, sizeof v);
    return v;
}
void store(std::vector<float>& to, std::size_t at, const Lanes& v) { std::memcpy(to.data() + at, &v, sizeof v); }
bool any(const decltype(Lanes() < Lanes())& mask) {
    std::array<std::uint64_t, 4> bits;
    std::memcpy(bits.data(), &mask, sizeof bits);
    return (bits[0] | bits[1] | bits[2] | bits[3]) != 0;
}

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

// Exact closest points of all voxels within `margin` of the surface, and on which side of it they are. The nearest triangle decides; where
// several share the nearest point (an edge, a corner), the one that faces the voxel most squarely does.
void near_surface(const TriangleMesh& mesh, const Volume& e, float margin, Closest& closest, std::vector<std::int8_t>& side) {
    const Slabs slabs(mesh, e, margin);
    // Squares of distances that differ by less are equal but for rounding, which large triangles make larger.
    const float tie = 1e-6f * e.voxel * (e.at(e.nx, e.ny, e.nz) - e.origin).norm();
    parallel_tasks(slabs.count(), [&](Index slab) {
        const int k_begin = slab * Slabs::thickness, k_end = std::min(e.nz, k_begin + Slabs::thickness);
        std::vector<float> squareness(grid_count(e.nx, e.ny, Slabs::thickness), 0.0f);
        for (std::uint32_t t : slabs.triangles(slab)) {
            const Vec3f &a = mesh.position[mesh.triangle[t][0]], &b = mesh.position[mesh.triangle[t][1]],
                        &c = mesh.position[mesh.triangle[t][2]];
            const Vec3f area = (b - a).cross(c - a);
            const float doubled = area.norm();
            if (doubled <= 0) continue;
            const NearTriangle triangle(a, b, c, area / doubled);
            const Vec3f low = (a.cwiseMin(b).cwiseMin(c).array() - margin - e.origin.array()) / e.voxel,
                        high = (a.cwiseMax(b).cwiseMax(c).array() + margin - e.origin.array()) / e.voxel;
            const int i0 = std::max(0, static_cast<int>(std::ceil(low.x()))), i1 = std::min(e.nx - 1, static_cast<int>(high.x()));
            const int j0 = std::max(0, static_cast<int>(std::ceil(low.y()))), j1 = std::min(e.ny - 1, static_cast<int>(high.y()));
            const int k0 = std::max(k_begin, static_cast<int>(std::ceil(low.z()))), k1 = std::min(k_end - 1, static_cast<int>(high.z()));
            for (int k = k0; k <= k1; ++k)
                for (int j = j0; j <= j1; ++j)
                    for (int first = i0; first <= i1; first += lanes) {
                        const int last = std::min(i1, first + lanes - 1);
                        const Vec3f p = e.at(first, j, k) - a;
                        // A large triangle's box holds voxels far beside it, and all of a row may be far above it.
                        const float above_first = triangle.above(p), above_last = triangle.above(e.at(last, j, k) - a);
                        if (std::min(above_first, above_last) > margin || std::max(above_first, above_last) < -margin) continue;
                        const NearTriangle::Row row = triangle.nearest(p, e.voxel);
                        for (int i = first; i <= last; ++i) {
                            const int l = i - first;
                            const float distance2 = row.distance2[l];
                            if (distance2 > margin * margin) continue;
                            const std::size_t at = e.index(i, j, k);
                            const float best = closest.distance2[at];
                            if (distance2 > best + tie) continue;
                            float& square = squareness[grid_index(i, j, k - k_begin, e.nx, e.ny)];
                            const bool nearer = distance2 < best - tie;
                            if (nearer || std::abs(row.above[l]) > square) {
                                square = std::abs(row.above[l]);
                                side[at] = row.above[l] < 0 ? -1 : 1;
                            }
                            if (distance2 < best) closest.set(at, Vec3f(row.x[l], row.y[l], row.z[l]) + a, distance2);
                        }
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
                        if (std::isfinite(closest.distance2[e.index(i, j, k)])) inside_[at({i / edge, j / edge, c})] = 1;
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
          limit2_(limit * limit), size_{e.nx, e.ny, e.nz}, stride_{1, grid_index(0, 1, e.nx), grid_index(0, 0, 1, e.nx, e.ny)} {}

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
        // Whole rows at once, where their neighbours along x are there.
        const bool rows = axis_ != 0 && first[0] > 0 && first[0] + lanes < e_.nx;
        std::array<int, 3> at{};
        for (at[2] = first[2]; at[2] < end[2]; ++at[2])
            for (at[1] = first[1]; at[1] < end[1]; ++at[1]) {
                at[0] = first[0];
                if (rows) ask_for_row(at, direction);
                else
                    for (; at[0] < end[0]; ++at[0]) ask(at, direction);
            }
    }

    std::size_t before(std::size_t here, int direction) const { return direction > 0 ? here - stride_[axis_] : here + stride_[axis_]; }

    void ask(const std::array<int, 3>& at, int direction) const {
        const std::size_t here = e_.index(at[0], at[1], at[2]), from = before(here, direction);
        float best = closest_.distance2[here];
        if (best <= margin2_ || !(closest_.distance2[from] < limit2_)) return;
        const Vec3f x = e_.at(at[0], at[1], at[2]);
        const int u = (axis_ + 1) % 3, v = (axis_ + 2) % 3;
        for (int dv = at[v] > 0 ? -1 : 0; dv <= (at[v] + 1 < size_[v] ? 1 : 0); ++dv)
            for (int du = at[u] > 0 ? -1 : 0; du <= (at[u] + 1 < size_[u] ? 1 : 0); ++du) {
                const std::size_t other = from + du * stride_[u] + dv * stride_[v];
                const Vec3f point(closest_.x[other], closest_.y[other], closest_.z[other]);
                const float distance2 = (x - point).squaredNorm();
                if (distance2 < best) closest_.set(here, point, best = distance2);
            }
    }

    // The same of `lanes` voxels along x.
    void ask_for_row(const std::array<int, 3>& at, int direction) const {
        const std::size_t here = e_.index(at[0], at[1], at[2]), from = before(here, direction);
        Lanes best = load(closest_.distance2, here);
        const auto asks = (best > margin2_) & (load(closest_.distance2, from) < limit2_);
        if (!any(asks)) return;
        const Vec3f first = e_.at(at[0], at[1], at[2]);
        const Lanes x = first.x() + counted * e_.voxel;
        Lanes px = load(closest_.x, here), py = load(closest_.y, here), pz = load(closest_.z, here);
        const int v = 3 - axis_;
        for (int dv = at[v] > 0 ? -1 : 0; dv <= (at[v] + 1 < size_[v] ? 1 : 0); ++dv)
            for (int dx = -1; dx <= 1; ++dx) {
                const std::size_t other = from + dx + dv * stride_[v];
                const Lanes qx = load(closest_.x, other), qy = load(closest_.y, other), qz = load(closest_.z, other);
                const Lanes rx = x - qx, ry = first.y() - qy, rz = first.z() - qz, distance2 = rx * rx + ry * ry + rz * rz;
                const auto nearer = asks & (distance2 < best);
                best = nearer ? distance2 : best;
                px = nearer ? qx : px, py = nearer ? qy : py, pz = nearer ? qz : pz;
            }
        store(closest_.distance2, here, best);
        store(closest_.x, here, px), store(closest_.y, here, py), store(closest_.z, here, pz);
    }

    const Volume& e_;
    const Band& band_;
    Closest& closest_;
    int axis_;
    float margin2_, limit2_;
    std::array<int, 3> size_;
    std::array<std::size_t, 3> stride_;
};

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
    Closest closest(volume.count());
    std::vector<std::int8_t> side(volume.count(), 0);
    // Each cell that the surface crosses has all its corners within sqrt(3) voxels of it: sides never leak through.
    const float margin = 1.75f * volume.voxel, limit = static_cast<float>(band) * volume.voxel;
    near_surface(mesh, volume, margin, closest, side);
    const Band held(volume, closest, band);
    for (int axis : {0, 1, 2}) Sweep(volume, held, axis, margin, limit + 2 * volume.voxel, closest).run();
    spread_sides(volume, side);

    volume.value.resize(volume.count());
    parallel_for(static_cast<Index>(volume.count()),
                 [&](Index n) { volume.value[n] = (side[n] < 0 ? -1.0f : 1.0f) * std::min(limit, std::sqrt(closest.distance2[n])); });
    return volume;
}

}  // namespace whorl
