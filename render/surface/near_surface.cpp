#include <cmath>

#include "engine/core/parallel.h"
#include "render/surface/closest_points.h"

namespace whorl::voxels {
namespace {

// (Height of a triangle)/(its longest edge) below which its normal is lost in rounding. Its neighbours cover its place.
constexpr float sliver = 1e-3f;

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

// Sides of the voxels in the planes k_begin <= k < k_end. @param above heights above the planes of the triangles that decide
void find_sides(const Volume& e, const Closest& closest, int k_begin, int k_end, const std::vector<float>& above,
                std::vector<std::int8_t>& side) {
    for (int k = k_begin; k < k_end; ++k)
        for (int j = 0; j < e.ny; ++j) {
            const float *const distance2 = closest.distance2 + closest.index(0, j, k), *const over =
                                                                                           above.data() + closest.index(0, j, k - k_begin);
            std::int8_t* const of_row = side.data() + e.index(0, j, k);
            std::int8_t last = 1;
            for (int i = 0; i < e.nx; ++i) {
                if (distance2[i] < infinity) last = over[i] < 0 ? -1 : 1;
                of_row[i] = last;
            }
            // A folded triangle at a sharp edge may put a voxel on the wrong side, and the rest of its row.
            for (int i = e.nx - 1; i >= 0 && of_row[i] < 0 && !(distance2[i] < infinity); --i) of_row[i] = 1;
        }
}

}  // namespace

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
        find_sides(e, closest, k_begin, k_end, above, side);
    });
}

}  // namespace whorl::voxels
