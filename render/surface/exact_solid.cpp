#include "render/surface/exact_solid.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

namespace whorl {
namespace {

constexpr std::size_t most_planes = 24;
constexpr float flat_cosine = 0.99999f;  // of the angle between normals of a flat triangle

/// Points of a curved surface and their normals.
struct CurvedPoints {
    std::vector<Vec3d> position, normal;
};

/// The ball or cylinder |x - c| = r through the points, by least squares of |x|^2 = 2 c . x + (r^2 - |c|^2). The axis of a cylinder is
/// normal to all normals. None if a point is farther than `off` [m] from it.
std::optional<Round> fitted(const CurvedPoints& points, double off) {
    const auto count = static_cast<double>(points.normal.size());
    Mat3d spread = Mat3d::Zero();
    Vec3d middle = Vec3d::Zero();
    for (std::size_t k = 0; k < points.normal.size(); ++k)
        spread += points.normal[k] * points.normal[k].transpose() / count, middle += points.position[k] / count;
    const Eigen::SelfAdjointEigenSolver<Mat3d> along(spread);
    const bool ball = along.eigenvalues()[0] > 1e-6;
    const Vec3d axis = ball ? Vec3d::Zero().eval() : Vec3d(along.eigenvectors().col(0));
    const auto across = [&](const Vec3d& x) { return Vec3d(x - middle - axis.dot(x - middle) * axis); };
    Eigen::Matrix4d square = 1e-12 * off * off * count * Eigen::Matrix4d::Identity();
    Eigen::Vector4d side = Eigen::Vector4d::Zero();
    for (const Vec3d& x : points.position) {
        const Vec3d p = across(x);
        const Eigen::Vector4d row(2 * p.x(), 2 * p.y(), 2 * p.z(), 1);
        square += row * row.transpose(), side += p.squaredNorm() * row;
    }
    const Eigen::Vector4d found = square.ldlt().solve(side);
    const Vec3d centre = found.head<3>();
    const double radius = std::sqrt(std::max(found.w() + centre.squaredNorm(), 0.0));
    for (const Vec3d& x : points.position)
        if (!(std::abs((across(x) - centre).norm() - radius) < off)) return {};
    return Round{(middle + centre).cast<float>(), static_cast<float>(radius), axis.cast<float>()};
}

/// Adds the triangle's plane unless it is known.
void add_plane(std::vector<Eigen::Vector4f>& planes, const Vec3f& n, float c, float off) {
    for (const Eigen::Vector4f& p : planes)
        if ((p.head<3>() - n).norm() < 1e-3f && std::abs(p.w() + c) < off) return;
    planes.emplace_back(n.x(), n.y(), n.z(), -c);
}

/// Whether all vertices are on the surface, and the sides of all triangles are inside and outside.
bool agrees(const ExactSolid& solid, const TriangleMesh& mesh, float size) {
    for (const Vec3f& x : mesh.position)
        if (std::abs(solid.distance(x)) > 3e-4f * size) return false;
    return std::all_of(mesh.triangle.begin(), mesh.triangle.end(), [&](const auto& t) {
        const Vec3f &a = mesh.position[t[0]], &b = mesh.position[t[1]], &c = mesh.position[t[2]];
        const Vec3f n = (b - a).cross(c - a), middle = (a + b + c) / 3;
        // More than the triangle is below a curved surface, less than its distance from an edge.
        const float shortest = std::min({(b - a).norm(), (c - b).norm(), (a - c).norm()});
        const Vec3f off = (std::min(0.2f * shortest, 5e-3f * size) + 2e-5f * size) * n.stableNormalized();
        return n.norm() < 1e-7f * size * size || (solid.distance(middle - off) < 0 && solid.distance(middle + off) > 0);
    });
}

}  // namespace

float ConvexBody::distance(const Vec3f& x) const {
    if (empty()) return 1e6f;
    float most = -1e6f;
    for (const Eigen::Vector4f& p : planes) most = std::max(most, p.head<3>().dot(x) + p.w());
    if (!round) return most;
    const Vec3f from = x - round->centre;
    return std::max(most, (from - round->axis.dot(from) * round->axis).norm() - round->radius);
}

std::optional<ExactSolid> exact_solid(const TriangleMesh& mesh) {
    if (mesh.triangle.empty() || mesh.normal.size() != mesh.position.size()) return {};
    Vec3f low = mesh.position[0], high = low;
    for (const Vec3f& x : mesh.position) low = low.cwiseMin(x), high = high.cwiseMax(x);
    const float size = (high - low).norm(), off = 1e-4f * size;
    std::vector<Eigen::Vector4f> planes;
    std::array<CurvedPoints, 2> curved;  // convex, concave
    for (const auto& t : mesh.triangle) {
        float least = 1, bend = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t a = t[k], b = t[(k + 1) % 3];
            least = std::min(least, mesh.normal[a].dot(mesh.normal[b]));
            bend += (mesh.normal[b] - mesh.normal[a]).dot(mesh.position[b] - mesh.position[a]);
        }
        if (least > flat_cosine) {
            const Vec3f& x = mesh.position[t[0]];
            const Vec3f across = (mesh.position[t[1]] - x).cross(mesh.position[t[2]] - x);
            if (across.norm() < 1e-7f * size * size) continue;
            add_plane(planes, across.normalized(), across.normalized().dot(x), off);
            if (planes.size() > most_planes) return {};
            continue;
        }
        for (const std::uint32_t v : t) {
            CurvedPoints& points = curved[bend < 0 ? 1 : 0];
            points.position.emplace_back(mesh.position[v].cast<double>()), points.normal.emplace_back(mesh.normal[v].cast<double>());
        }
    }
    ExactSolid solid;
    for (const Eigen::Vector4f& p : planes) {
        const bool hull =
            std::all_of(mesh.position.begin(), mesh.position.end(), [&](const Vec3f& x) { return p.head<3>().dot(x) + p.w() < off; });
        (hull ? solid.outer : solid.cavity).planes.push_back(hull ? p : Eigen::Vector4f(-p));
    }
    for (const bool concave : {false, true}) {
        if (curved[concave].position.empty()) continue;
        const auto round = fitted(curved[concave], static_cast<double>(off));
        if (!round) return {};
        (concave ? solid.cavity : solid.outer).round = round;
    }
    return agrees(solid, mesh, size) ? std::optional(solid) : std::nullopt;
}

ExactSolid moved(const ExactSolid& solid, const Mat3f& rotation, const Vec3f& translation) {
    ExactSolid after = solid;
    for (ConvexBody* body : {&after.outer, &after.cavity}) {
        for (Eigen::Vector4f& p : body->planes) {
            const Vec3f n = rotation * p.head<3>();
            p << n, p.w() - n.dot(translation);
        }
        if (body->round)
            body->round->centre = rotation * body->round->centre + translation, body->round->axis = rotation * body->round->axis;
    }
    return after;
}

}  // namespace whorl
