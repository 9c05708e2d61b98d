#include <Eigen/Geometry>
#include <functional>
#include <numbers>

#include "engine/geometry/vessel.h"

namespace whorl {
namespace {

/// Adds a quad a, b, c, d, as two triangles whose front is on the side of the normals. Triangles without area are left out.
void add_quad(const std::array<Vec3d, 4>& x, const std::array<Vec3d, 4>& normal, TriangleMesh& mesh) {
    const auto first = static_cast<std::uint32_t>(mesh.position.size());
    for (std::size_t k = 0; k < 4; ++k) mesh.position.push_back(x[k].cast<float>()), mesh.normal.push_back(normal[k].cast<float>());
    for (const std::array<std::uint32_t, 3>& t : {std::array<std::uint32_t, 3>{0, 1, 2}, std::array<std::uint32_t, 3>{0, 2, 3}}) {
        const Vec3d area = (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]);
        const bool front = area.dot(normal[t[0]] + normal[t[1]] + normal[t[2]]) > 0;
        if (area.norm() > 1e-9 * (x[2] - x[0]).squaredNorm())
            mesh.triangle.push_back({first + t[0], first + t[front ? 1 : 2], first + t[front ? 2 : 1]});
    }
}

}  // namespace

/// One end of a side: the position of a point of the profile at distance s from the axis, and the direction away from the axis.
struct VesselSweep::Edge {
    std::function<Vec3d(double s)> place;
    Vec3d away;
};

void VesselSweep::add_side(const VesselProfile& profile, const Edge& from, const Edge& to, TriangleMesh& mesh) const {
    // The polygon from the axis along the outside to the rim, and back along the inside.
    std::vector<Eigen::Vector2d> points = profile.outer;
    points.insert(points.end(), profile.inner.rbegin(), profile.inner.rend());
    for (std::size_t k = 0; k + 1 < points.size(); ++k) {
        const Eigen::Vector2d &a = points[k], &b = points[k + 1];
        const bool rim = k + 1 == profile.outer.size(), inside = k >= profile.outer.size();
        const Eigen::Vector2d across = Eigen::Vector2d(b.y() - a.y(), a.x() - b.x()).normalized();
        const double sign = inside ? -1 : 1;
        const auto normal = [&](const Edge& edge, const Eigen::Vector2d& at) {
            const Eigen::Vector2d flat = profile.round && !rim ? Eigen::Vector2d(sign * at.normalized()) : across;
            return Vec3d(flat.x() * edge.away + flat.y() * n_);
        };
        const auto place = [&](const Edge& edge, const Eigen::Vector2d& at) { return Vec3d(origin_ + edge.place(at.x()) + at.y() * n_); };
        add_quad({place(from, a), place(to, a), place(to, b), place(from, b)},
                 {normal(from, a), normal(to, a), normal(to, b), normal(from, b)}, mesh);
    }
}

TriangleMesh VesselSweep::turned(const VesselProfile& profile, int around) const {
    TriangleMesh mesh;
    const auto edge = [&](int l) {
        const double angle = 2 * std::numbers::pi * (l % around) / around;
        const Vec3d away = std::cos(angle) * u_ + std::sin(angle) * v_;
        return Edge{[away](double s) { return Vec3d(s * away); }, away};
    };
    for (int l = 0; l < around; ++l) add_side(profile, edge(l), edge(l + 1), mesh);
    return mesh;
}

TriangleMesh VesselSweep::squared(const VesselProfile& profile, double wider) const {
    TriangleMesh mesh;
    const auto edge = [&](double p, double q, const Vec3d& away) {
        return Edge{[this, p, q, wider](double s) { return Vec3d(p * s * u_ + q * (s > 0 ? s + wider : 0) * v_); }, away};
    };
    for (const double side : {-1.0, 1.0}) {
        add_side(profile, edge(side, -1, side * u_), edge(side, 1, side * u_), mesh);
        add_side(profile, edge(-1, side, side * v_), edge(1, side, side * v_), mesh);
    }
    return mesh;
}

TriangleMesh VesselSweep::extruded(const VesselProfile& profile, double depth) const {
    TriangleMesh mesh;
    for (const double side : {-1.0, 1.0}) {
        const auto edge = [&](double end) {
            return Edge{[this, side, end, depth](double s) { return Vec3d(side * s * u_ + end * depth * v_); }, side * u_};
        };
        add_side(profile, edge(-1), edge(1), mesh);
        for (const double end : {-1.0, 1.0}) {
            const auto at = [&](const Eigen::Vector2d& x) { return Vec3d(origin_ + side * x.x() * u_ + x.y() * n_ + end * depth * v_); };
            const Vec3d normal = end * v_;
            for (std::size_t k = 0; k + 1 < profile.outer.size(); ++k)
                add_quad({at(profile.outer[k]), at(profile.outer[k + 1]), at(profile.inner[k + 1]), at(profile.inner[k])},
                         {normal, normal, normal, normal}, mesh);
        }
    }
    return mesh;
}

}  // namespace whorl
