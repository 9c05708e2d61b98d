#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <map>

#include "engine/core/errors.h"
#include "engine/geometry/mesh_file.h"
#include "engine/geometry/vessel.h"

namespace whorl {
namespace {

/// The part of a mesh below the plane n . x = rim [m]. Corners within `snap` [m] of the plane are moved onto it.
TriangleMesh below_rim(const TriangleMesh& mesh, const Vec3d& n, double rim, double snap) {
    TriangleMesh part;
    const auto height = [&](const Vec3d& x) {
        const double h = n.dot(x) - rim;
        return std::abs(h) < snap ? 0 : h;
    };
    const auto crossing = [&](Vec3d a, Vec3d b) {  // equal for both triangles at an edge
        if (std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end())) std::swap(a, b);
        return Vec3d(a + height(a) / (height(a) - height(b)) * (b - a));
    };
    for (const auto& t : mesh.triangle) {
        std::vector<Vec3d> kept;
        double lowest = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3d a = mesh.position[t[k]].cast<double>(), b = mesh.position[t[(k + 1) % 3]].cast<double>();
            const double h = height(a), next = height(b);
            lowest = std::min(lowest, h);
            if (h <= 0) kept.emplace_back(h < 0 ? a : Vec3d(a - (n.dot(a) - rim) * n));
            if ((h < 0 && next > 0) || (h > 0 && next < 0)) kept.push_back(crossing(a, b));
        }
        if (!(lowest < 0)) continue;
        const auto first = static_cast<std::uint32_t>(part.position.size());
        for (const Vec3d& x : kept) part.position.push_back(x.cast<float>());
        for (std::uint32_t k = 2; k < kept.size(); ++k) part.triangle.push_back({first, first + k - 1, first + k});
    }
    weld(part);
    return part;
}

void turn_over(TriangleMesh& mesh) {
    for (auto& t : mesh.triangle) std::swap(t[1], t[2]);
    for (Vec3f& n : mesh.normal) n = -n;
}

class MeshVessel final : public Shape {
public:
    MeshVessel(std::shared_ptr<const Shape> cavity, const TriangleMesh& walls, const Vec3d& n, double rim, double wall)
        : cavity_(std::move(cavity)), sheet_(make_sheet(walls)), n_(n.cast<Real>()), rim_(static_cast<Real>(rim)),
          wall_(static_cast<Real>(wall)) {
        remarks = cavity_->remarks;
        Vec3 low, high;
        sheet_->bounds(low, high);
        known_ = Real(2e-6) * (high - low).norm();
        draw(walls);
    }

    Real distance(const Vec3& x) const override { return near(x).distance; }
    Vec3 normal(const Vec3& x) const override { return near(x).normal; }
    void bounds(Vec3& min, Vec3& max) const override { min = min_, max = max_; }
    bool shell() const override { return true; }
    TriangleMesh mesh(Real, Real) const override { return drawn_; }

private:
    struct Near {
        Real distance;
        Vec3 normal;
    };
    Real height(const Vec3& x) const { return n_.dot(x) - rim_; }

    /// Distance u from the cavity's walls, without sign, and the direction away from them. @param outside whether x is outside the cavity
    Near from_walls(const Vec3& x, bool outside) const {
        const Real u = sheet_->distance(x);
        const Vec3 n = sheet_->normal(x);
        if (std::abs(u) < known_) return {std::abs(u), outside ? n : Vec3(-n)};
        return {std::abs(u), u < 0 ? Vec3(-n) : n};
    }
    /// Moves x onto the outside of the wall, u = wall, by Newton's method; in the plane of the rim if `on_rim`.
    Vec3 on_outside(Vec3 x, bool on_rim) const {
        if (on_rim) x -= height(x) * n_;
        for (int k = 0; k < 4; ++k) {
            const Near from = from_walls(x, true);
            const Vec3 slope = on_rim ? Vec3(from.normal - from.normal.dot(n_) * n_) : from.normal;
            const Real steep = slope.squaredNorm();
            if (!(steep > Real(1e-3))) break;
            x += (wall_ - from.distance) / steep * slope;
        }
        return x;
    }
    static Near from_point(const Vec3& x, const Vec3& point, const Vec3& otherwise) {
        const Real length = (x - point).norm();
        return {length, length > 0 ? Vec3((x - point) / length) : otherwise};
    }
    Near near(const Vec3& x) const {
        const Real h = height(x);
        if (h > 0) {
            const Vec3 foot = x - h * n_;
            if (cavity_->distance(foot - known_ * n_) <= 0) return from_walls(x, false);
            return std::abs(sheet_->distance(foot)) <= wall_ ? Near{h, n_} : from_point(x, on_outside(foot, true), n_);
        }
        const bool outside = cavity_->distance(x) > 0;
        const Near from = from_walls(x, outside);
        if (!outside) return from;
        if (from.distance <= wall_) {
            const Real least = std::min({from.distance, wall_ - from.distance, -h});
            return {-least, least == from.distance ? Vec3(-from.normal) : least == -h ? n_ : from.normal};
        }
        // The outside ends at the rim: if the nearest point of its surface would be above the rim, the rim's outer edge is nearest.
        if (height(x - (from.distance - wall_) * from.normal) > 0) return from_point(x, on_outside(x, true), from.normal);
        return {from.distance - wall_, from.normal};
    }

    /// The cavity's walls, the outside at their corners' normals, and the rim between them.
    void draw(const TriangleMesh& walls) {
        std::vector<Vec3d> normal(walls.position.size(), Vec3d::Zero());
        std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
        const auto at = [&](std::uint32_t v) { return Vec3d(walls.position[v].cast<double>()); };
        for (const auto& t : walls.triangle)
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t a = t[k], b = t[(k + 1) % 3], c = t[(k + 2) % 3];
                const Vec3d ab = at(b) - at(a), ac = at(c) - at(a), across = ab.cross(ac);
                normal[a] += std::atan2(across.norm(), ab.dot(ac)) * across.stableNormalized();
                edges[{a, b}] += 1, edges[{b, a}] -= 1;
            }
        std::vector<char> on_rim(walls.position.size());
        for (const auto& [edge, count] : edges)
            if (count != 0) on_rim[edge.first] = on_rim[edge.second] = 1;
        TriangleMesh out = walls, rim;
        for (std::uint32_t v = 0; v < out.position.size(); ++v) {
            Vec3 way = normal[v].stableNormalized().cast<Real>();
            if (on_rim[v]) way = (way - way.dot(n_) * n_).stableNormalized();
            Vec3 x = on_outside(at(v).cast<Real>() + wall_ * way, on_rim[v] != 0);
            if (height(x) > 0) x = on_outside(x, true);
            out.position[v] = x.cast<float>();
        }
        for (const auto& [edge, count] : edges) {
            if (count != 1) continue;
            const auto first = static_cast<std::uint32_t>(rim.position.size());
            const auto& [a, b] = edge;
            for (const Vec3f& x : {walls.position[a], walls.position[b], out.position[b], out.position[a]}) rim.position.push_back(x);
            rim.normal.insert(rim.normal.end(), 4, n_.cast<float>());
            rim.triangle.push_back({first, first + 1, first + 2}), rim.triangle.push_back({first, first + 2, first + 3});
        }
        drawn_ = sheet_->mesh(0, 0);
        turn_over(drawn_);
        append(drawn_, make_sheet(std::move(out))->mesh(0, 0));
        append(drawn_, rim);
        min_ = max_ = drawn_.position.front().cast<Real>();
        for (const Vec3f& x : drawn_.position) min_ = min_.cwiseMin(x.cast<Real>()), max_ = max_.cwiseMax(x.cast<Real>());
    }

    std::shared_ptr<const Shape> cavity_, sheet_;  ///< the closed mesh; its surface below the rim
    Vec3 n_, min_, max_;
    Real rim_, wall_, known_ = 0;  ///< m; known_: distance from which the direction of a difference is known
    TriangleMesh drawn_;
};

}  // namespace

std::shared_ptr<const Shape> make_mesh_vessel(std::shared_ptr<const Shape> cavity, const Vec3d& n, double rim, double wall) {
    Vec3 low, high;
    cavity->bounds(low, high);
    const double bottom = n.dot((n.sum() > 0 ? low : high).cast<double>()), top = n.dot((n.sum() > 0 ? high : low).cast<double>()),
                 size = static_cast<double>((high - low).norm());
    const std::string range =
        fmt::format("{:g} to {:g} m", std::min(bottom * n.sum(), top * n.sum()), std::max(bottom * n.sum(), top * n.sum()));
    if (!(rim > bottom + 1e-3 * size && rim <= top + 1e-5 * size))
        throw InputError({}, fmt::format("the rim at {:g} m does not cut the mesh", rim * n.sum()), "", "the mesh spans " + range);
    const TriangleMesh walls = below_rim(cavity->mesh(0, 0), n, std::min(rim, top), 1e-5 * size);
    for (const auto& t : walls.triangle) {
        const Vec3f middle = (walls.position[t[0]] + walls.position[t[1]] + walls.position[t[2]]) / 3;
        if (std::abs(cavity->distance(middle.cast<Real>())) > Real(1e-4 * size))
            throw InputError({}, "the mesh has parts that overlap, so it has no single cavity", "unite its parts in a mesh editor");
    }
    return std::make_shared<MeshVessel>(std::move(cavity), walls, n, std::min(rim, top), wall);
}

}  // namespace whorl
