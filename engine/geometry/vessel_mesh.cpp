#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
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

/// The mesh with all faces moved outward by `wall` [m], so that edges stay sharp. A vertex moves to the point at that distance from all its
/// faces; if there is no such point, to the best one by least squares, weighted by the faces' angles. Vertices of a lid in the plane
/// n . x = rim stay in that plane.
TriangleMesh grown(const TriangleMesh& mesh, double wall, const Vec3d& n, double rim, double snap) {
    constexpr double longest = 6;  // largest displacement, in walls: that of an edge of 19 degrees
    std::vector<std::vector<std::pair<double, Vec3d>>> faces(mesh.position.size());  // angle and normal of each face at a vertex
    std::vector<char> on_lid(mesh.position.size());
    for (const auto& t : mesh.triangle) {
        std::array<Vec3d, 3> x;
        for (std::size_t k = 0; k < 3; ++k) x[k] = mesh.position[t[k]].cast<double>();
        const bool lid = std::all_of(x.begin(), x.end(), [&](const Vec3d& at) { return std::abs(n.dot(at) - rim) < snap; });
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3d ab = x[(k + 1) % 3] - x[k], ac = x[(k + 2) % 3] - x[k], across = ab.cross(ac);
            if (lid) on_lid[t[k]] = 1;
            else faces[t[k]].emplace_back(std::atan2(across.norm(), ab.dot(ac)), across.stableNormalized());
        }
    }
    TriangleMesh out = mesh;
    for (std::size_t v = 0; v < faces.size(); ++v) {
        Vec3d move = Vec3d::Zero(), lacking = Vec3d::Zero();
        Mat3d square = 1e-6 * Mat3d::Identity();
        for (auto& [angle, normal] : faces[v]) {
            if (on_lid[v]) normal -= normal.dot(n) * n;
            move += angle * normal;
        }
        move = wall * move.stableNormalized();
        for (const auto& [angle, normal] : faces[v])
            square += angle * normal * normal.transpose(), lacking += angle * (wall - normal.dot(move)) * normal;
        move += square.ldlt().solve(lacking);
        out.position[v] += Vec3d(std::min(1.0, longest * wall / std::max(move.norm(), wall)) * move).cast<float>();
    }
    return out;
}

using Loop = std::vector<std::uint32_t>;

/// Loops of the mesh's open edges, in the direction in which the missing triangles pass them.
std::vector<Loop> open_loops(const TriangleMesh& mesh) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> missing;
    for (const auto& t : mesh.triangle)
        for (std::size_t k = 0; k < 3; ++k) missing[{t[(k + 1) % 3], t[k]}] += 1, missing[{t[k], t[(k + 1) % 3]}] -= 1;
    std::multimap<std::uint32_t, std::uint32_t> next;
    for (const auto& [edge, count] : missing)
        if (count > 0) next.insert(edge);
    std::vector<Loop> loops;
    while (!next.empty()) {
        Loop& loop = loops.emplace_back();
        for (auto at = next.begin(); at != next.end(); at = next.find(loop.back() == loop.front() ? ~0u : loop.back())) {
            if (loop.empty()) loop.push_back(at->first);
            loop.push_back(at->second);
            next.erase(at);
        }
        loop.pop_back();
    }
    return loops;
}

/// Closes the mesh by triangles between its open edges, which lie in a plane. @param n normal of these triangles
void close_rim(TriangleMesh& mesh, const Vec3d& n) {
    std::vector<Vec3d> x;
    for (const Vec3f& at : mesh.position) x.push_back(at.cast<double>());
    std::vector<Loop> rings, holes;
    for (Loop& loop : open_loops(mesh)) {
        double area = 0;
        for (std::size_t k = 2; k < loop.size(); ++k) area += n.dot((x[loop[k - 1]] - x[loop[0]]).cross(x[loop[k]] - x[loop[0]]));
        (area > 0 ? rings : holes).push_back(std::move(loop));
    }
    while (!holes.empty() && !rings.empty()) {  // a bridge joins the nearest hole: being the shortest, it crosses no other edge
        double least = std::numeric_limits<double>::infinity();
        std::array<std::size_t, 4> bridge{};
        for (std::size_t r = 0; r < rings.size(); ++r)
            for (std::size_t h = 0; h < holes.size(); ++h)
                for (std::size_t i = 0; i < rings[r].size(); ++i)
                    for (std::size_t j = 0; j < holes[h].size(); ++j)
                        if (const double far = (x[rings[r][i]] - x[holes[h][j]]).squaredNorm(); far < least)
                            least = far, bridge = {r, h, i, j};
        Loop &ring = rings[bridge[0]], &hole = holes[bridge[1]];
        std::rotate(hole.begin(), hole.begin() + static_cast<std::ptrdiff_t>(bridge[3]), hole.end());
        hole.push_back(hole[0]), hole.push_back(ring[bridge[2]]);
        ring.insert(ring.begin() + static_cast<std::ptrdiff_t>(bridge[2]) + 1, hole.begin(), hole.end());
        holes.erase(holes.begin() + static_cast<std::ptrdiff_t>(bridge[1]));
    }
    for (Loop& ring : rings) triangulate(x, std::move(ring), mesh.triangle);
}

class MeshVessel final : public Shape {
public:
    /// @param cavity the closed mesh @param walls its surface below the rim @param outside surface of the wall's outside below the rim
    MeshVessel(std::shared_ptr<const Shape> cavity, TriangleMesh walls, TriangleMesh outside, const Vec3d& n, double rim)
        : cavity_(std::move(cavity)), sheet_(make_sheet(walls)), n_(n.cast<Real>()), rim_(static_cast<Real>(rim)) {
        remarks = cavity_->remarks;
        Vec3 low, high;
        sheet_->bounds(low, high);
        known_ = Real(2e-6) * (high - low).norm();
        TriangleMesh solid = outside, inside = walls;
        for (auto& t : walls.triangle) std::swap(t[1], t[2]);
        append(solid, walls);
        for (TriangleMesh* open : {&solid, &outside, &inside}) close_rim(*open, n);
        drawn_ = make_sheet(std::move(solid));
        body_ = make_mesh(std::move(outside), "the outside of the vessel");
        bulk_ = hollowed(body_->bulk(), make_mesh(std::move(inside), "the cavity of the vessel")->bulk());
    }

    Real distance(const Vec3& x) const override {
        if (over_cavity(x)) return std::abs(sheet_->distance(x));
        const Real out = body_->distance(x);
        return out < 0 ? std::max(out, -std::abs(sheet_->distance(x))) : out;
    }
    Vec3 normal(const Vec3& x) const override {
        if (over_cavity(x)) return away_from_walls(x, false);
        const Real out = body_->distance(x);
        return out < 0 && std::abs(sheet_->distance(x)) < -out ? Vec3(-away_from_walls(x, true)) : body_->normal(x);
    }
    void bounds(Vec3& min, Vec3& max) const override { drawn_->bounds(min, max); }
    bool shell() const override { return true; }
    MassProperties bulk() const override { return bulk_; }
    TriangleMesh mesh(Real edge, Real extent) const override { return drawn_->mesh(edge, extent); }

private:
    /// Whether x is in the cavity or above it.
    bool over_cavity(const Vec3& x) const {
        const Real h = n_.dot(x) - rim_;
        return cavity_->distance(h > 0 ? Vec3(x - (h + known_) * n_) : x) <= 0;
    }
    /// Direction away from the cavity's walls. @param outside whether x is outside the cavity
    Vec3 away_from_walls(const Vec3& x, bool outside) const {
        const Real u = sheet_->distance(x);
        const Vec3 n = sheet_->normal(x);
        return (std::abs(u) < known_ ? !outside : u < 0) ? Vec3(-n) : n;
    }

    std::shared_ptr<const Shape> cavity_, sheet_;  ///< the closed mesh; its surface below the rim
    std::shared_ptr<const Shape> body_, drawn_;    ///< the vessel with its cavity filled up to the rim; the surface of the vessel
    MassProperties bulk_;
    Vec3 n_;
    Real rim_, known_ = 0;  ///< m; known_: distance from which the direction of a difference is known
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
    rim = std::min(rim, top);
    const double snap = 1e-5 * size;
    TriangleMesh whole = cavity->mesh(0, 0);
    weld(whole);
    const TriangleMesh walls = below_rim(whole, n, rim, snap);
    for (const auto& t : walls.triangle) {
        const Vec3f middle = (walls.position[t[0]] + walls.position[t[1]] + walls.position[t[2]]) / 3;
        if (std::abs(cavity->distance(middle.cast<Real>())) > Real(1e-4 * size))
            throw InputError({}, "the mesh has parts that overlap, so it has no single cavity", "unite its parts in a mesh editor");
    }
    return std::make_shared<MeshVessel>(std::move(cavity), walls, below_rim(grown(whole, wall, n, rim, snap), n, rim, snap), n, rim);
}

}  // namespace whorl
