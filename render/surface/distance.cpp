#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>

#include "engine/core/parallel.h"
#include "render/surface/surface.h"

namespace whorl {
namespace {

constexpr double most_voxels = 16e6;
// (Height of a triangle)/(its longest edge) below which its normal is lost in rounding. Its neighbours cover its place.
constexpr float sliver = 1e-3f;

// Eight numbers, one per voxel of a row.
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

// Nearest point of the surface found for each voxel, and its squared distance. Rows are padded by a few voxels at infinite distance, so
// that eight voxels can be read from any voxel of a row.
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
    // Forgets the points of the planes k <= plane < end.
    void clear(int k, int end) {
        for (float* v : {x, y, z, distance2}) std::fill(v + plane_ * k, v + plane_ * end, infinity);
    }

private:
    std::size_t row_, plane_, count_;
    std::unique_ptr<float[]> all_;

public:
    float *x, *y, *z, *distance2;
};

// Volume of the voxels about the mesh, without values.
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

// Lists of the triangles within a margin of each slab (consecutive planes of voxels along z).
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

// A triangle, for queries by the voxels of a row. Positions are relative to its first corner [m].
class NearTriangle {
public:
    // For each voxel: the triangle's nearest point, its squared distance, and the signed height above the triangle's plane.
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
    // Signed height of a row's voxels above the triangle's plane [m]. @param p the row's first voxel @param step edge of a voxel [m]
    Lanes above(const Vec3f& p, float step) const { return normal_.dot(p) + counted * (step * normal_.x()); }

    // @param p the row's first voxel @param step edge of a voxel [m]
    Row nearest(const Vec3f& p, float step) const {
        const Lanes x = p.x() + counted * step, none = x - x;
        Row row{none, none, none, none + std::numeric_limits<float>::max(), above(p, step)};
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

// Exact closest points of all voxels within `margin` of the surface. The nearest triangle decides on which side of the surface a voxel is.
// If several triangles share the nearest point (on an edge or a corner), the one that faces the voxel most squarely decides. Voxels without
// a near triangle are on the same side as the voxel before them in their row. Each row begins and ends outside.
// @param side set for each voxel: -1 inside, 1 outside
void near_surface(const TriangleMesh& mesh, const Volume& e, float margin, Closest& closest, std::vector<std::int8_t>& side) {
    const Slabs slabs(mesh, e, margin);
    // Squared distances that differ by less than this [m^2] count as equal, because of rounding errors.
    const float tie = 1e-6f * e.voxel * (e.at(e.nx, e.ny, e.nz) - e.origin).norm();
    const float margin2 = margin * margin;
    constexpr float rounding = 1e-4f;
    parallel_tasks(slabs.count(), [&](Index slab) {
        const int k_begin = slab * Slabs::thickness, k_end = std::min(e.nz, k_begin + Slabs::thickness);
        closest.clear(k_begin, k_end);
        std::vector<float> above(closest.plane() * Slabs::thickness + lanes,
                                 0.0f);  // height above the plane of the triangle that decides on the side
        for (std::uint32_t t : slabs.triangles(slab)) {
            const Vec3f &a = mesh.position[mesh.triangle[t][0]], &b = mesh.position[mesh.triangle[t][1]],
                        &c = mesh.position[mesh.triangle[t][2]];
            const Vec3f area = (b - a).cross(c - a);
            const float doubled = area.norm(), longest2 = std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
            if (doubled <= sliver * longest2) continue;
            const NearTriangle triangle(a, b, c, area / doubled);
            const Vec3f least = a.cwiseMin(b).cwiseMin(c) - a, most = a.cwiseMax(b).cwiseMax(c) - a;
            const Vec3f first_corner = (a + least - e.origin).array() - margin, last_corner = (a + most - e.origin).array() + margin;
            const Vec3f low = first_corner / e.voxel, high = last_corner / e.voxel;
            const int i0 = std::max(0, static_cast<int>(std::ceil(low.x()))), i1 = std::min(e.nx - 1, static_cast<int>(high.x()));
            const int j0 = std::max(0, static_cast<int>(std::ceil(low.y()))), j1 = std::min(e.ny - 1, static_cast<int>(high.y()));
            const int k0 = std::max(k_begin, static_cast<int>(std::ceil(low.z()))), k1 = std::min(k_end - 1, static_cast<int>(high.z()));
            const auto outside = [&](float at, int axis) { return std::max(0.0f, std::max(least[axis] - at, at - most[axis])); };
            for (int k = k0; k <= k1; ++k)
                for (int j = j0; j <= j1; ++j)
                    for (int first = i0; first <= i1; first += lanes) {
                        const Vec3f p = e.at(first, j, k) - a;
                        const std::size_t at = closest.index(first, j, k), at_above = closest.index(first, j, k - k_begin);
                        const Lanes best = load(closest.distance2 + at);
                        // Skips triangles whose box or plane is farther away than the distance found.
                        const float beside_y = outside(p.y(), 1), beside_z = outside(p.z(), 2);
                        const Lanes x = p.x() + counted * e.voxel, plane = triangle.above(p, e.voxel);
                        Lanes beside_x = x < least.x() ? least.x() - x : x - most.x();
                        beside_x = beside_x > 0.0f ? beside_x : x - x;
                        const Lanes box2 = beside_x * beside_x + (beside_y * beside_y + beside_z * beside_z);
                        const Lanes furthest2 = best < margin2 ? best : x - x + margin2, plane2 = plane * plane;
                        const auto may = (1 - rounding) * (box2 < plane2 ? plane2 : box2) <= furthest2 + tie;
                        if (!any(may & (counted <= static_cast<float>(i1 - first)))) continue;
                        const NearTriangle::Row row = triangle.nearest(p, e.voxel);
                        const Lanes best_above = load(above.data() + at_above);
                        const auto near =
                            (row.distance2 <= margin2) & (row.distance2 <= best + tie) & (counted <= static_cast<float>(i1 - first));
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
        for (int k = k_begin; k < k_end; ++k)
            for (int j = 0; j < e.ny; ++j) {
                const float *const distance2 = closest.distance2 + closest.index(0, j, k), *const over = above.data() +
                                                                                                         closest.index(0, j, k - k_begin);
                std::int8_t* const of_row = side.data() + e.index(0, j, k);
                std::int8_t last = 1;
                for (int i = 0; i < e.nx; ++i) {
                    if (distance2[i] < infinity) last = over[i] < 0 ? -1 : 1;
                    of_row[i] = last;
                }
                // A folded triangle at a sharp edge may put a voxel on the wrong side, and the rest of its row.
                for (int i = e.nx - 1; i >= 0 && of_row[i] < 0 && !(distance2[i] < infinity); --i) of_row[i] = 1;
            }
    });
}

// Blocks of voxels that the band may reach: blocks with a voxel near the surface, and those within the band of them.
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

// Carries closest points from plane to plane along one axis, forwards and backwards: each voxel beyond the exact margin tries the points of
// the nine voxels next to it in the plane before. Six such sweeps reach every voxel along a nearly straight path.
class Sweep {
public:
    Sweep(const Volume& e, const Band& band, int axis, float margin, float limit, Closest& closest)
        : e_(e), band_(band), closest_(closest), axis_(axis), margin2_(margin * margin),
          limit2_(limit * limit), size_{e.nx, e.ny, e.nz}, stride_{1, closest.row(), closest.plane()} {}

    void run() const {
        const int n = size_[axis_];
        std::vector<std::vector<std::array<int, 3>>> blocks(band_.count(axis_));  // blocks of the band, by plane of blocks
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
    // Results of the previous plane, from its first voxel on.
    struct Known {
        const float *x, *y, *z;
        std::size_t row;  // number of floats from one row to the next
    };

    // Updates the voxels of a block that lie in the plane.
    void block(const std::array<int, 3>& b, int plane, int direction) const {
        std::array<int, 3> first{}, end{};
        for (int a = 0; a < 3; ++a) first[a] = b[a] * Band::edge, end[a] = std::min(size_[a], first[a] + Band::edge);
        first[axis_] = plane, end[axis_] = plane + 1;
        if (axis_ == 0) return across_rows(first, end, direction);
        const int v = 3 - axis_;  // axis along which rows are stacked
        std::array<int, 3> at = first;
        for (; at[v] < end[v]; ++at[v]) {
            const std::size_t here = closest_.index(at[0], at[1], at[2]), from = before(here, direction);
            const Known known{closest_.x + from, closest_.y + from, closest_.z + from, stride_[v]};
            float* const to[4] = {closest_.x + here, closest_.y + here, closest_.z + here, closest_.distance2 + here};
            const Vec3f p = e_.at(at[0], at[1], at[2]);
            const Lanes none = counted - counted;
            ask({p.x() + counted * e_.voxel, none + p.y(), none + p.z()}, load(closest_.distance2 + from), at[v] > 0, at[v] + 1 < size_[v],
                known, to);
        }
    }

    // Updates a plane across the rows. First copies its voxels and those of the plane before, so that voxels along y are contiguous.
    void across_rows(const std::array<int, 3>& first, const std::array<int, 3>& end, int direction) const {
        constexpr int edge = Band::edge, wide = 2 * lanes;
        const int count_y = end[1] - first[1], count_z = end[2] - first[2];
        const std::size_t here = closest_.index(first[0], first[1], first[2]), from = before(here, direction);
        const auto place = [&](int j, int k) { return closest_.row() * j + closest_.plane() * k; };
        alignas(32) float from2[edge][lanes], kept[edge][4][lanes];
        bool is_asked = false;
        for (int k = 0; k < count_z; ++k)
            for (int j = 0; j < lanes; ++j) {
                from2[k][j] = j < count_y ? closest_.distance2[from + place(j, k)] : infinity;
                kept[k][3][j] = j < count_y ? closest_.distance2[here + place(j, k)] : 0;
                is_asked |= kept[k][3][j] > margin2_ && from2[k][j] < limit2_;
            }
        if (!is_asked) return;
        float known[3][edge + 2][wide];  // begins one voxel before the block, along both axes
        const float* const source[3] = {closest_.x, closest_.y, closest_.z};
        for (int c = 0; c < 3; ++c) {
            for (int k = -1; k <= count_z; ++k)
                for (int j = -1; j <= lanes; ++j) {
                    const int y = first[1] + j, z = first[2] + k;
                    const bool is_there = y >= 0 && y < size_[1] && z >= 0 && z < size_[2];
                    known[c][k + 1][j + 1] = is_there ? source[c][closest_.index(first[0] - direction, y, z)] : infinity;
                }
            for (int k = 0; k < count_z; ++k)
                for (int j = 0; j < lanes; ++j) kept[k][c][j] = j < count_y ? source[c][here + place(j, k)] : 0;
        }
        float* const target[4] = {closest_.x, closest_.y, closest_.z, closest_.distance2};
        for (int k = 0; k < count_z; ++k) {
            const Vec3f p = e_.at(first[0], first[1], first[2] + k);
            const Lanes none = counted - counted;
            float* const to[4] = {kept[k][0], kept[k][1], kept[k][2], kept[k][3]};
            if (!ask({none + p.x(), p.y() + counted * e_.voxel, none + p.z()}, load(from2[k]), true, true,
                     {known[0][k + 1] + 1, known[1][k + 1] + 1, known[2][k + 1] + 1, wide}, to))
                continue;
            for (int c = 0; c < 4; ++c)
                for (int j = 0; j < count_y; ++j) target[c][here + place(j, k)] = kept[k][c][j];
        }
    }

    std::size_t before(std::size_t here, int direction) const { return direction > 0 ? here - stride_[axis_] : here + stride_[axis_]; }

    // Consecutive voxels try the closest points of the voxel before each and of the eight around that one.
    // @param from2 squared distances of the voxels before @param to x, y, z and squared distance of each voxel, updated
    // @return whether any voxel tried
    bool ask(const std::array<Lanes, 3>& voxel, const Lanes& from2, bool has_row_before, bool has_row_after, const Known& known,
             float* const (&to)[4]) const {
        Lanes best = load(to[3]);
        const auto asks = (best > margin2_) & (from2 < limit2_);
        if (!any(asks)) return false;
        Lanes px = load(to[0]), py = load(to[1]), pz = load(to[2]);
        for (int r = has_row_before ? -1 : 0; r <= (has_row_after ? 1 : 0); ++r)
            for (int n = -1; n <= 1; ++n) {
                const std::ptrdiff_t other = static_cast<std::ptrdiff_t>(known.row) * r + n;
                const Lanes qx = load(known.x + other), qy = load(known.y + other), qz = load(known.z + other);
                const Lanes rx = voxel[0] - qx, ry = voxel[1] - qy, rz = voxel[2] - qz, distance2 = rx * rx + ry * ry + rz * rz;
                const auto nearer = asks & (distance2 < best);
                best = nearer ? distance2 : best;
                px = nearer ? qx : px, py = nearer ? qy : py, pz = nearer ? qz : pz;
            }
        store(to[0], px), store(to[1], py), store(to[2], pz), store(to[3], best);
        return true;
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
    // Each cell that the surface crosses has all corners within sqrt(3) voxels of the surface, so the side never leaks through it.
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
