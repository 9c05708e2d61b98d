#include "engine/geometry/mesh_shape.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "engine/core/parallel.h"
#include "engine/core/triangle.h"

namespace whorl {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

double angle_between(const Vec3d& a, const Vec3d& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

}  // namespace

MeshShape::MeshShape(TriangleMesh mesh) : mesh_(std::move(mesh)) {
    for (const Vec3f& x : mesh_.position) vertex_.push_back(x.cast<double>());
    std::vector<std::uint32_t> order(mesh_.triangle.size());
    std::iota(order.begin(), order.end(), 0u);
    nodes_.reserve(2 * order.size());
    build(order, 0, order.size());
    order_ = std::move(order);
    for (std::size_t t = 0; t < mesh_.triangle.size(); ++t) face_normal_.push_back(area_vector(mesh_.triangle[t]).stableNormalized());
    weigh_normals();
    find_crossings();
}

Vec3 MeshShape::normal(const Vec3& x) const {
    Vec3d n, offset;
    const double distance = nearest(x.cast<double>(), infinity, offset, n);
    // Very near the surface, round-off dominates the vector to the nearest point, so the surface's own normal is used there.
    const double size = nodes_[0].box.diagonal().norm();
    if (std::abs(distance) < 1e-6 * size) return n.stableNormalized().cast<Real>();
    return (offset / distance).cast<Real>();
}

void MeshShape::weigh_normals() {
    corner_normal_.assign(vertex_.size(), Vec3d::Zero());
    std::map<std::pair<std::uint32_t, std::uint32_t>, Vec3d> edges;
    for (std::size_t t = 0; t < mesh_.triangle.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t a = mesh_.triangle[t][k], b = mesh_.triangle[t][(k + 1) % 3], c = mesh_.triangle[t][(k + 2) % 3];
            corner_normal_[a] += angle_between(vertex_[b] - vertex_[a], vertex_[c] - vertex_[a]) * face_normal_[t];
            edges.try_emplace(std::minmax(b, c), Vec3d::Zero()).first->second += face_normal_[t];
        }
    edge_normal_.resize(mesh_.triangle.size());
    for (std::size_t t = 0; t < mesh_.triangle.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k)
            edge_normal_[t][k] = edges[std::minmax(mesh_.triangle[t][(k + 1) % 3], mesh_.triangle[t][(k + 2) % 3])];
}

/// Counts the faces whose outer side is inside the mesh. Just outside a face the winding number is 0, unless the mesh intersects
/// itself or the face is turned inward. Each face is tested at its centre and near its corners.
void MeshShape::find_crossings() {
    const double step = 1e-9 * box().diagonal().norm();
    std::vector<char> crosses(mesh_.triangle.size());
    parallel_for(static_cast<Index>(crosses.size()), [&](Index t) {
        const Triangle& c = mesh_.triangle[t];
        for (const Vec3d& w : {Vec3d(3, 3, 3), Vec3d(4, 4, 1), Vec3d(4, 1, 4), Vec3d(1, 4, 4)}) {
            const Vec3d x = (w[0] * vertex_[c[0]] + w[1] * vertex_[c[1]] + w[2] * vertex_[c[2]]) / 9;
            if (face_normal_[t].squaredNorm() > 0.5 && winding(x + step * face_normal_[t]) != 0) crosses[t] = 1;
        }
    });
    crossings_ = std::count(crosses.begin(), crosses.end(), 1);
}

/// Winding number of the surface about x, from its crossings with the ray from x along z. The two faces at an edge use the same test
/// of the side of the edge on which the ray lies, so no crossing is lost or counted twice.
int MeshShape::winding(const Vec3d& x) const {
    int sum = 0;
    std::uint32_t stack[64];
    int depth = 0;
    stack[depth++] = 0;
    while (depth > 0) {
        const std::uint32_t at = stack[--depth];
        const Node& node = nodes_[at];
        const Vec3d &min = node.box.min(), &max = node.box.max();
        if (x.x() < min.x() || x.x() > max.x() || x.y() < min.y() || x.y() > max.y() || x.z() > max.z()) continue;
        if (node.right != 0) stack[depth++] = at + 1, stack[depth++] = node.right;
        for (std::uint32_t k = node.begin; k < (node.right == 0 ? node.end : node.begin); ++k) {
            const Triangle& c = mesh_.triangle[order_[k]];
            int turns = 0;  // number of turns of the triangle's rim about the ray
            for (std::size_t e = 0; e < 3; ++e) {
                const Vec3d &a = vertex_[c[e]], &b = vertex_[c[(e + 1) % 3]];
                if ((a.y() <= x.y()) == (b.y() <= x.y())) continue;
                const bool up = a.y() <= x.y();
                const Vec3d &low = up ? a : b, &high = up ? b : a;
                if ((high.x() - low.x()) * (x.y() - low.y()) > (x.x() - low.x()) * (high.y() - low.y())) turns += up ? 1 : -1;
            }
            if (turns * area_vector(c).dot(vertex_[c[0]] - x) > 0) sum += turns;
        }
    }
    return sum;
}

void MeshShape::build(std::vector<std::uint32_t>& order, std::size_t begin, std::size_t end) {
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

/// Signed distance, with offset = x - nearest point and the normal of the nearest feature (not of unit length).
double MeshShape::nearest(const Vec3d& x, double bound, Vec3d& offset, Vec3d& normal) const {
    double best = bound * bound;
    offset = normal = Vec3d::UnitY();
    if (!x.allFinite()) return infinity;
    bool found_any = false;
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
                found_any = true;
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
    if (!found_any) return infinity;
    const bool inside = box().contains(x) && (crossings_ > 0 ? winding(x) != 0 : offset.dot(normal) < 0);
    return inside ? -std::sqrt(best) : std::sqrt(best);
}

/// For drawing: normals are smooth across edges at which the faces differ by less than 40 degrees, and sharp across other edges.
TriangleMesh MeshShape::mesh(Real, Real) const {
    const double sharp = std::cos(40 * std::acos(-1.0) / 180);
    std::vector<std::vector<std::uint32_t>> faces(vertex_.size());
    for (std::uint32_t t = 0; t < mesh_.triangle.size(); ++t)
        for (std::uint32_t corner : mesh_.triangle[t]) faces[corner].push_back(t);

    TriangleMesh drawn;
    std::vector<std::vector<std::uint32_t>> made(vertex_.size());  // vertices made for each corner, one per normal
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

}  // namespace whorl
