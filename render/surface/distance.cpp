#include <array>
#include <cmath>

#include "engine/core/parallel.h"
#include "render/surface/closest_points.h"

namespace whorl {
namespace {

using namespace voxels;

constexpr double most_voxels = 16e6;

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
