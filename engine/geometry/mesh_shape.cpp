#include "engine/geometry/mesh_shape.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
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
        check_closed(name);
        for (std::size_t t = 0; t < mesh_.triangle.size(); ++t) face_normal_.push_back(area_vector(mesh_.triangle[t]).stableNormalized());
        weigh_normals();
        std::vector<std::uint32_t> order(mesh_.triangle.size());
        std::iota(order.begin(), order.end(), 0u);
        nodes_.reserve(2 * order.size());
        build(order, 0, order.size());
        order_ = std::move(order);
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

    void check_closed(const std::string& name) {
        std::map<std::pair<std::uint32_t, std::uint32_t>, int> turns, uses;  // of each edge: passes one way less passes back; all passes
        for (const Triangle& t : mesh_.triangle)
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t a = t[k], b = t[(k + 1) % 3];
                turns[std::minmax(a, b)] += a < b ? 1 : -1;
                uses[std::minmax(a, b)] += 1;
            }
        long open = 0, turned = 0;
        for (const auto& [edge, count] : uses) {
            if (count % 2 != 0) ++open;
            else if (turns[edge] != 0) ++turned;
        }
        if (open > 0)
            throw InputError({name}, fmt::format("the mesh is not closed: {} of its {} edges are open", open, uses.size()),
                             "inside and outside need a closed surface: fill the holes in a mesh editor");
        if (turned > 0)
            throw InputError({name}, fmt::format("the faces beside {} edges are turned against each other", turned),
                             "make all faces look outward in a mesh editor");
        double volume = 0;
        for (const Triangle& t : mesh_.triangle) volume += (vertex_[t[0]] - vertex_[0]).dot(area_vector(t)) / 6;
        if (volume < 0)
            for (Triangle& t : mesh_.triangle) std::swap(t[1], t[2]);
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
