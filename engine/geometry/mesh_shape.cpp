#include "engine/geometry/mesh_shape.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <iterator>
#include <map>
#include <numeric>

#include "engine/core/errors.h"
#include "engine/core/triangle.h"
#include "engine/geometry/mesh_file.h"

namespace whorl {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

/// Signed distance by the nearest triangle, in a tree of boxes; the sign from the angle-weighted normal of the nearest corner, edge or face
/// (Baerentzen and Aanaes 2005): right also where the nearest point is shared by triangles that disagree.
class Mesh final : public Shape {
public:
    Mesh(TriangleMesh mesh, const std::string& name) : mesh_(std::move(mesh)) {
        for (const Vec3f& x : mesh_.position) vertex_.push_back(x.cast<double>());
        find_closed_parts(name);
        std::vector<std::uint32_t> order(mesh_.triangle.size());
        std::iota(order.begin(), order.end(), 0u);
        nodes_.reserve(2 * order.size());
        build(order, 0, order.size());
        order_ = std::move(order);
        turn_parts();
        for (std::size_t t = 0; t < mesh_.triangle.size(); ++t) face_normal_.push_back(area_vector(mesh_.triangle[t]).stableNormalized());
        weigh_normals();
    }

    Real distance(const Vec3& x) const override {
        Vec3d normal, offset;
        return Real(nearest(x.cast<double>(), offset, normal));
    }
    Vec3 normal(const Vec3& x) const override {
        Vec3d n, offset;
        const double distance = nearest(x.cast<double>(), offset, n);
        // Very near the surface the direction to it is rounding: there the surface's own normal is the better one.
        const double size = nodes_[0].box.diagonal().norm();
        if (std::abs(distance) < 1e-6 * size) return n.stableNormalized().cast<Real>();
        return (offset / distance).cast<Real>();
    }
    void bounds(Vec3& min, Vec3& max) const override {
        min = nodes_[0].box.min().cast<Real>();
        max = nodes_[0].box.max().cast<Real>();
    }
    TriangleMesh mesh(Real, Real) const override;

private:
    struct Node {
        Eigen::AlignedBox3d box;
        std::uint32_t begin = 0, end = 0;  ///< of order_, in a leaf
        std::uint32_t right = 0;           ///< 0 in a leaf; the left child follows its parent
    };

    Vec3d area_vector(const Triangle& t) const { return (vertex_[t[1]] - vertex_[t[0]]).cross(vertex_[t[2]] - vertex_[t[0]]); }

    /// Which triangles hang together by their edges. @throws InputError where the mesh has holes, or neighbours look different ways
    void find_closed_parts(const std::string& name) {
        struct Edge {
            int turns = 0, uses = 0;  ///< passes one way less passes back; all passes
            std::uint32_t first = 0;  ///< triangle
        };
        std::map<std::pair<std::uint32_t, std::uint32_t>, Edge> edges;
        part_.resize(mesh_.triangle.size());
        std::iota(part_.begin(), part_.end(), 0u);
        const auto root = [&](std::uint32_t t) {
            while (part_[t] != t) t = part_[t] = part_[part_[t]];
            return t;
        };
        for (std::uint32_t t = 0; t < mesh_.triangle.size(); ++t)
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t a = mesh_.triangle[t][k], b = mesh_.triangle[t][(k + 1) % 3];
                Edge& edge = edges.try_emplace(std::minmax(a, b), Edge{0, 0, t}).first->second;
                edge.turns += a < b ? 1 : -1;
                edge.uses += 1;
                part_[root(t)] = root(edge.first);
            }
        for (std::uint32_t t = 0; t < mesh_.triangle.size(); ++t) part_[t] = root(t);
        long open = 0, turned = 0;
        for (const auto& [ends, edge] : edges) {
            if (edge.uses % 2 != 0) ++open;
            else if (edge.turns != 0) ++turned;
        }
        if (open > 0)
            throw InputError({name}, fmt::format("the mesh is not closed: {} of its {} edges are open", open, edges.size()),
                             "inside and outside need a closed surface: fill the holes in a mesh editor");
        if (turned > 0)
            throw InputError({name}, fmt::format("the faces beside {} edges are turned against each other", turned),
                             "make all faces look outward in a mesh editor");
    }

    /// Makes every part look outward, and inward where it is a hollow: wholly inside an odd number of others.
    void turn_parts() {
        std::map<std::uint32_t, std::vector<std::uint32_t>> parts;
        for (std::uint32_t t = 0; t < mesh_.triangle.size(); ++t) parts[part_[t]].push_back(t);
        for (const auto& [part, triangles] : parts) {
            double volume = 0;
            const Vec3d& origin = vertex_[mesh_.triangle[part][0]];
            for (const std::uint32_t t : triangles)
                volume += (vertex_[mesh_.triangle[t][0]] - origin).dot(area_vector(mesh_.triangle[t])) / 6;
            const bool hollow = parts.size() > 1 && parts_around(triangles) % 2 == 1;
            if (hollow ? volume > 0 : volume < 0)
                for (const std::uint32_t t : triangles) std::swap(mesh_.triangle[t][1], mesh_.triangle[t][2]);
        }
    }

    /// How many other parts hold all corners of one.
    std::size_t parts_around(const std::vector<std::uint32_t>& triangles) const {
        std::vector<std::uint32_t> corners, around, both;
        for (const std::uint32_t t : triangles) corners.insert(corners.end(), mesh_.triangle[t].begin(), mesh_.triangle[t].end());
        std::sort(corners.begin(), corners.end());
        corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
        for (const std::uint32_t corner : corners) {
            std::vector<std::uint32_t> here = parts_at(vertex_[corner]);
            std::erase(here, part_[triangles[0]]);
            both.clear();
            if (corner == corners[0]) both = here;
            else std::set_intersection(around.begin(), around.end(), here.begin(), here.end(), std::back_inserter(both));
            around.swap(both);
            if (around.empty()) break;
        }
        return around.size();
    }

    /// The parts that hold a place, in order: a ray from there passes through them an odd number of times.
    std::vector<std::uint32_t> parts_at(const Vec3d& x) const {
        const Vec3d way(0.5376129, 0.7071427, 0.4592373);  // all positive, along nothing that people model
        std::vector<std::uint32_t> hit, stack{0};
        while (!stack.empty()) {
            const std::uint32_t at = stack.back();
            const Node& node = nodes_[at];
            stack.pop_back();
            const Vec3d in = (node.box.min() - x).cwiseQuotient(way), out = (node.box.max() - x).cwiseQuotient(way);
            if (std::max(0.0, in.maxCoeff()) > out.minCoeff()) continue;
            if (node.right != 0) stack.insert(stack.end(), {at + 1, node.right});
            else
                for (std::uint32_t k = node.begin; k < node.end; ++k)
                    if (passes(x, way, mesh_.triangle[order_[k]])) hit.push_back(part_[order_[k]]);
        }
        std::sort(hit.begin(), hit.end());
        std::vector<std::uint32_t> inside;
        for (const std::uint32_t part : hit) {
            if (!inside.empty() && inside.back() == part) inside.pop_back();
            else inside.push_back(part);
        }
        return inside;
    }
    /// Whether the ray from x meets the triangle (Moeller and Trumbore 1997).
    bool passes(const Vec3d& x, const Vec3d& way, const Triangle& t) const {
        const Vec3d ab = vertex_[t[1]] - vertex_[t[0]], ac = vertex_[t[2]] - vertex_[t[0]], from = x - vertex_[t[0]];
        const Vec3d p = way.cross(ac), q = from.cross(ab);
        const double scale = ab.dot(p), u = from.dot(p) / scale, v = way.dot(q) / scale;
        return u >= 0 && v >= 0 && u + v <= 1 && ac.dot(q) / scale > 0;
    }

    void weigh_normals() {
        corner_normal_.assign(vertex_.size(), Vec3d::Zero());
        std::map<std::pair<std::uint32_t, std::uint32_t>, Vec3d> edges;
        for (std::size_t t = 0; t < mesh_.triangle.size(); ++t)
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t a = mesh_.triangle[t][k], b = mesh_.triangle[t][(k + 1) % 3], c = mesh_.triangle[t][(k + 2) % 3];
                corner_normal_[a] += angle(vertex_[b] - vertex_[a], vertex_[c] - vertex_[a]) * face_normal_[t];
                edges.try_emplace(std::minmax(b, c), Vec3d::Zero()).first->second += face_normal_[t];
            }
        edge_normal_.resize(mesh_.triangle.size());
        for (std::size_t t = 0; t < mesh_.triangle.size(); ++t)
            for (std::size_t k = 0; k < 3; ++k)
                edge_normal_[t][k] = edges[std::minmax(mesh_.triangle[t][(k + 1) % 3], mesh_.triangle[t][(k + 2) % 3])];
    }
    static double angle(const Vec3d& a, const Vec3d& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

    void build(std::vector<std::uint32_t>& order, std::size_t begin, std::size_t end) {
        const std::size_t self = nodes_.size();
        nodes_.emplace_back();
        Eigen::AlignedBox3d box, centres;
        const auto centre = [&](std::uint32_t t) {
            const Triangle& corner = mesh_.triangle[t];
            return Vec3d(vertex_[corner[0]] + vertex_[corner[1]] + vertex_[corner[2]]);
        };
        for (std::size_t k = begin; k < end; ++k) {
            for (std::uint32_t corner : mesh_.triangle[order[k]]) box.extend(vertex_[corner]);
            centres.extend(centre(order[k]));
        }
        nodes_[self].box = box;
        nodes_[self].begin = static_cast<std::uint32_t>(begin);
        nodes_[self].end = static_cast<std::uint32_t>(end);
        if (end - begin <= 4) return;
        int axis = 0;
        centres.sizes().maxCoeff(&axis);
        const std::size_t middle = (begin + end) / 2;
        const auto at = [&](std::size_t k) { return order.begin() + static_cast<std::ptrdiff_t>(k); };
        std::nth_element(at(begin), at(middle), at(end), [&](std::uint32_t s, std::uint32_t t) {
            const double cs = centre(s)[axis], ct = centre(t)[axis];
            return cs != ct ? cs < ct : s < t;
        });
        build(order, begin, middle);
        nodes_[self].right = static_cast<std::uint32_t>(nodes_.size());
        build(order, middle, end);
    }

    /// Signed distance; offset = x - nearest point; normal of the feature there, not unit.
    double nearest(const Vec3d& x, Vec3d& offset, Vec3d& normal) const {
        double best = std::numeric_limits<double>::infinity();
        offset = normal = Vec3d::UnitY();
        if (!x.allFinite()) return best;
        std::uint32_t stack[64];
        int depth = 0;
        stack[depth++] = 0;
        while (depth > 0) {
            const std::uint32_t at = stack[--depth];
            const Node& node = nodes_[at];
            if (node.box.squaredExteriorDistance(x) >= best) continue;
            if (node.right == 0) {
                for (std::uint32_t k = node.begin; k < node.end; ++k) {
                    const std::uint32_t t = order_[k];
                    const Triangle& corner = mesh_.triangle[t];
                    const auto found = nearest_on_triangle(x, vertex_[corner[0]], vertex_[corner[1]], vertex_[corner[2]]);
                    const double r2 = (x - found.point).squaredNorm();
                    if (!(r2 < best)) continue;
                    best = r2;
                    offset = x - found.point;
                    const std::size_t f = static_cast<std::size_t>(found.feature);
                    normal = f < 3 ? corner_normal_[corner[f]] : f < 6 ? edge_normal_[t][f - 3] : face_normal_[t];
                }
                continue;
            }
            const std::uint32_t left = at + 1, right = node.right;
            const bool left_first = nodes_[left].box.squaredExteriorDistance(x) <= nodes_[right].box.squaredExteriorDistance(x);
            stack[depth++] = left_first ? right : left;
            stack[depth++] = left_first ? left : right;
        }
        return offset.dot(normal) < 0 ? -std::sqrt(best) : std::sqrt(best);
    }

    TriangleMesh mesh_;
    std::vector<std::uint32_t> part_;  ///< of each triangle: one triangle of its part
    std::vector<Vec3d> vertex_, face_normal_, corner_normal_;
    std::vector<std::array<Vec3d, 3>> edge_normal_;
    std::vector<Node> nodes_;
    std::vector<std::uint32_t> order_;
};

/// Normals are smooth across edges of less than 40 degrees and sharp across the others.
TriangleMesh Mesh::mesh(Real, Real) const {
    const double sharp = std::cos(40 * std::acos(-1.0) / 180);
    std::vector<std::vector<std::uint32_t>> faces(vertex_.size());
    for (std::uint32_t t = 0; t < mesh_.triangle.size(); ++t)
        for (std::uint32_t corner : mesh_.triangle[t]) faces[corner].push_back(t);

    TriangleMesh drawn;
    std::vector<std::vector<std::uint32_t>> made(vertex_.size());  // vertices drawn for each corner: one a normal
    for (std::uint32_t t = 0; t < mesh_.triangle.size(); ++t) {
        Triangle triangle{};
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t corner = mesh_.triangle[t][k];
            Vec3d sum = Vec3d::Zero();
            for (std::uint32_t s : faces[corner])
                if (face_normal_[s].dot(face_normal_[t]) > sharp) sum += area_vector(mesh_.triangle[s]);
            const Vec3f normal = (sum.norm() > 0 ? Vec3d(sum.normalized()) : Vec3d(Vec3d::UnitY())).cast<float>();
            std::uint32_t vertex = ~0u;
            for (std::uint32_t v : made[corner])
                if ((drawn.normal[v] - normal).squaredNorm() < 1e-8f) vertex = v;
            if (vertex == ~0u) {
                vertex = static_cast<std::uint32_t>(drawn.position.size());
                drawn.position.push_back(mesh_.position[corner]);
                drawn.normal.push_back(normal);
                made[corner].push_back(vertex);
            }
            triangle[k] = vertex;
        }
        drawn.triangle.push_back(triangle);
    }
    return drawn;
}

}  // namespace

std::shared_ptr<const Shape> make_mesh(TriangleMesh mesh, const std::string& name) {
    weld(mesh);
    if (mesh.triangle.empty()) throw InputError({name}, "the mesh holds no triangles");
    return std::make_shared<Mesh>(std::move(mesh), name);
}

std::shared_ptr<const Shape> make_mesh(const std::filesystem::path& file, double scale, const Vec3d& position) {
    TriangleMesh mesh = read_mesh(file);
    for (Vec3f& x : mesh.position) x = (scale * x.cast<double>() + position).cast<float>();
    return make_mesh(std::move(mesh), file.string());
}

}  // namespace whorl
