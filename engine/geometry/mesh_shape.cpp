#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include "engine/core/errors.h"
#include "engine/core/parallel.h"
#include "engine/core/triangle.h"
#include "engine/geometry/mesh_file.h"
#include "engine/geometry/shape.h"
#include "engine/geometry/vessel.h"

namespace whorl {
namespace {

using Triangle = std::array<std::uint32_t, 3>;
constexpr double infinity = std::numeric_limits<double>::infinity();

/// Signed distance to the nearest triangle, found in a tree of boxes. The sign follows from the angle-weighted normal of the nearest
/// corner, edge or face (Baerentzen and Aanaes 2005). This sign is right even if the triangles that share the nearest point give different
/// signs. In a self-intersecting mesh, points with a winding number other than 0 are inside.
class Mesh final : public Shape {
public:
    explicit Mesh(TriangleMesh mesh) : mesh_(std::move(mesh)) {
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

    std::ptrdiff_t crossings() const { return crossings_; }
    bool crosses_much() const { return 100 * crossings_ > std::ssize(mesh_.triangle); }
    Real distance(const Vec3& x) const override { return Real(distance(x.cast<double>(), infinity)); }
    /// Signed distance [m]; infinite if its magnitude is not below the bound.
    double distance(const Vec3d& x, double bound) const {
        Vec3d normal, offset;
        return nearest(x, bound, offset, normal);
    }
    bool holds(const Vec3d& x) const { return winding(x) != 0; }
    Vec3 normal(const Vec3& x) const override {
        Vec3d n, offset;
        const double distance = nearest(x.cast<double>(), infinity, offset, n);
        // Very near the surface, round-off dominates the vector to the nearest point, so the surface's own normal is used there.
        const double size = nodes_[0].box.diagonal().norm();
        if (std::abs(distance) < 1e-6 * size) return n.stableNormalized().cast<Real>();
        return (offset / distance).cast<Real>();
    }
    void bounds(Vec3& min, Vec3& max) const override {
        min = nodes_[0].box.min().cast<Real>();
        max = nodes_[0].box.max().cast<Real>();
    }
    TriangleMesh mesh(Real, Real) const override;
    const Eigen::AlignedBox3d& box() const { return nodes_[0].box; }

private:
    struct Node {
        Eigen::AlignedBox3d box;
        std::uint32_t begin = 0, end = 0;  ///< range of order_, in a leaf
        std::uint32_t right = 0;           ///< index of the right child, 0 in a leaf; the left child follows its parent
    };

    Vec3d area_vector(const Triangle& t) const { return (vertex_[t[1]] - vertex_[t[0]]).cross(vertex_[t[2]] - vertex_[t[0]]); }

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
    /// Counts the faces whose outer side is inside the mesh. Just outside a face the winding number is 0, unless the mesh intersects
    /// itself or the face is turned inward. Each face is tested at its centre and near its corners.
    void find_crossings() {
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
    int winding(const Vec3d& x) const {
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

    /// Signed distance, with offset = x - nearest point and the normal of the nearest feature (not of unit length).
    double nearest(const Vec3d& x, double bound, Vec3d& offset, Vec3d& normal) const {
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

    TriangleMesh mesh_;
    std::vector<Vec3d> vertex_, face_normal_, corner_normal_;
    std::vector<std::array<Vec3d, 3>> edge_normal_;
    std::vector<Node> nodes_;
    std::vector<std::uint32_t> order_;
    std::ptrdiff_t crossings_ = 0;  ///< number of faces whose outer side is inside the mesh
};

/// For drawing: normals are smooth across edges at which the faces differ by less than 40 degrees, and sharp across other edges.
TriangleMesh Mesh::mesh(Real, Real) const {
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

/// Closed parts that may overlap, touch or contain each other. The solid is the union of the parts, but a part inside another is a hollow
/// in that part.
class Parts final : public Shape {
public:
    Parts(const std::vector<TriangleMesh>& meshes, std::vector<std::string> notes) {
        std::vector<Part> parts;
        std::ptrdiff_t crossings = 0;
        for (const TriangleMesh& mesh : meshes) {
            parts.push_back({std::make_shared<Mesh>(mesh), bulk_of(mesh).volume});
            crossings += parts.back().mesh->crossings(), overlap_ |= parts.back().mesh->crosses_much();
        }
        if (crossings > 0)
            notes.push_back(fmt::format(
                "the mesh intersects itself, with {} faces inside it; the inside is where the winding number is not 0", crossings));
        remarks = std::move(notes);
        std::vector<std::size_t> from_left(parts.size());
        std::iota(from_left.begin(), from_left.end(), 0u);
        std::vector<std::size_t> by_volume = from_left;
        const auto box = [&](std::size_t k) -> const Eigen::AlignedBox3d& { return parts[k].mesh->box(); };
        std::stable_sort(from_left.begin(), from_left.end(), [&](auto i, auto j) { return box(i).min().x() < box(j).min().x(); });
        std::stable_sort(by_volume.begin(), by_volume.end(), [&](auto i, auto j) { return parts[i].volume > parts[j].volume; });
        std::vector<std::vector<std::size_t>> near(parts.size());
        for (std::size_t i = 0; i < parts.size(); ++i)
            for (std::size_t j = i + 1; j < parts.size(); ++j) {
                const std::size_t a = from_left[i], b = from_left[j];
                if (box(b).min().x() > box(a).max().x()) break;
                if (box(a).intersects(box(b))) near[a].push_back(b), near[b].push_back(a);
            }
        for (const std::size_t k : by_volume)
            for (const std::size_t other : near[k]) {
                if (parts[other].volume < parts[k].volume) continue;
                if (parts[other].volume > parts[k].volume && within(meshes[k], *parts[other].mesh))
                    parts[k].depth = std::max(parts[k].depth, parts[other].depth + 1);
                else overlap_ = overlap_ || (box(k).intersection(box(other)).sizes().array() > 0).all();
            }
        // Parts that are near no other are merged into one mesh, because there the nearest face determines the sign.
        TriangleMesh alone;
        for (std::size_t k = 0; k < parts.size(); ++k) {
            if (near[k].empty()) append(alone, meshes[k]);
            else parts_.push_back(parts[k]);
        }
        if (!alone.triangle.empty()) parts_.push_back({std::make_shared<Mesh>(std::move(alone))});
        std::stable_sort(parts_.begin(), parts_.end(), [](const Part& p, const Part& q) { return p.depth < q.depth; });
    }

    Real distance(const Vec3& x) const override {
        std::size_t whose = 0;
        return Real(distance(x.cast<double>(), whose));
    }
    Vec3 normal(const Vec3& x) const override {
        std::size_t whose = 0;
        distance(x.cast<double>(), whose);
        return parts_[whose].sign() * parts_[whose].mesh->normal(x);
    }
    void bounds(Vec3& min, Vec3& max) const override {
        const Eigen::AlignedBox3d box = whole_box();
        min = box.min().cast<Real>(), max = box.max().cast<Real>();
    }
    /// If parts overlap, integrates over evenly spread points (Roberts's sequence), because a sum over the surfaces would count overlaps
    /// twice.
    MassProperties bulk() const override {
        if (!overlap_) return Shape::bulk();
        const Eigen::AlignedBox3d box = whole_box();
        const Vec3d apart(0.8191725133961645, 0.6710436067037893, 0.5497004779019703);
        const int count = std::clamp(20'000'000 / static_cast<int>(parts_.size()), 20'000, 200'000);  // each point queries every part
        const double share = box.volume() / count;
        MassProperties bulk;
        Vec3d first = Vec3d::Zero();
        for (int n = 1; n <= count; ++n) {
            const Vec3d turns = n * apart, r = box.sizes().cwiseProduct(turns - Vec3d(turns.array().floor()));
            bool inside = false;
            for (const Part& part : parts_)
                if (part.mesh->holds(box.min() + r)) inside = !part.hollow();
            if (!inside) continue;
            bulk.volume += share, first += share * r, bulk.moment += share * r * r.transpose();
        }
        if (!(bulk.volume > 0)) return {};
        const Vec3d centre = first / bulk.volume;
        bulk.moment -= bulk.volume * centre * centre.transpose();
        bulk.centre = box.min() + centre;
        return bulk;
    }
    TriangleMesh mesh(Real edge, Real extent) const override {
        TriangleMesh all;
        for (const Part& part : parts_) {
            TriangleMesh one = part.mesh->mesh(edge, extent);
            if (part.hollow()) {
                for (Vec3f& n : one.normal) n = -n;
                for (Triangle& t : one.triangle) std::swap(t[1], t[2]);
            }
            append(all, one);
        }
        return all;
    }

private:
    struct Part {
        std::shared_ptr<const Mesh> mesh;
        double volume = 0;
        int depth = 0;  ///< number of parts that enclose this part
        bool hollow() const { return depth % 2 == 1; }
        Real sign() const { return hollow() ? Real(-1) : Real(1); }
    };

    /// Whether `inner` lies in `outer`. Of the corners and middles of inner's triangles, none must be outside and at least one must be
    /// inside; the surfaces may touch.
    static bool within(const TriangleMesh& inner, const Mesh& outer) {
        const double rounding = 1e-6 * outer.box().min().cwiseAbs().cwiseMax(outer.box().max().cwiseAbs()).norm();
        bool inside = false;
        for (const Triangle& t : inner.triangle) {
            const Vec3d a = inner.position[t[0]].cast<double>(), b = inner.position[t[1]].cast<double>(),
                        c = inner.position[t[2]].cast<double>();
            for (const Vec3d& x : {a, b, c, Vec3d((a + b + c) / 3)}) {
                const double distance = outer.distance(x, infinity);
                if (distance > rounding) return false;
                inside = inside || distance < -rounding;
            }
        }
        return inside;
    }

    /// Signed distance to the union of the solid parts minus the hollows. @param whose index of the nearest part
    double distance(const Vec3d& x, std::size_t& whose) const {
        double best = infinity;
        for (std::size_t k = 0; k < parts_.size(); ++k) {
            const Part& part = parts_[k];
            const double sign = part.sign(), gap = std::sqrt(part.mesh->box().squaredExteriorDistance(x));
            if (gap > 0 && gap >= sign * best) continue;
            const double one = sign * part.mesh->distance(x, gap > 0 ? sign * best : infinity);
            if (part.hollow() ? one > best : one < best) best = one, whose = k;
        }
        return best;
    }
    Eigen::AlignedBox3d whole_box() const {
        Eigen::AlignedBox3d box;
        for (const Part& part : parts_) box.extend(part.mesh->box());
        return box;
    }

    std::vector<Part> parts_;  ///< sorted by depth: enclosing parts come before the parts in them
    bool overlap_ = false;
};

}  // namespace

std::shared_ptr<const Shape> make_mesh(TriangleMesh mesh, const std::string& name) {
    std::vector<std::string> remarks;
    const std::size_t read = mesh.triangle.size();
    weld(mesh);
    if (mesh.triangle.empty()) throw InputError({name}, "the mesh contains no triangles");
    if (const std::size_t lost = read - mesh.triangle.size()) remarks.push_back(fmt::format("faces without an area left out: {}", lost));
    const std::vector<TriangleMesh> parts = closed_parts(std::move(mesh), name, remarks);
    if (parts.size() == 1)
        if (const auto one = std::make_shared<Mesh>(parts[0]); one->crossings() == 0) {
            one->remarks = std::move(remarks);
            return one;
        }
    return std::make_shared<Parts>(parts, std::move(remarks));
}

std::shared_ptr<const Shape> make_sheet(TriangleMesh surface) { return std::make_shared<Mesh>(std::move(surface)); }

std::shared_ptr<const Shape> make_mesh(const std::filesystem::path& file, double scale, const Vec3d& position, const std::string& node) {
    return make_mesh(read_mesh(file, scale, position, node), file.string());
}

}  // namespace whorl
