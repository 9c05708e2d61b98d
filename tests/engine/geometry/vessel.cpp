#include "engine/geometry/vessel.h"

#include <catch2/catch.hpp>
#include <functional>
#include <numbers>
#include <random>

#include "engine/core/errors.h"

using namespace whorl;

namespace {

using Box3 = Eigen::AlignedBox3d;
using Point2 = Eigen::Vector2d;

constexpr double vessel_wall = 0.02;

ShapeKeys vessel_keys(const std::string& kind, const std::string& open = "top") {
    ShapeKeys keys;
    keys.kind = kind, keys.open = open, keys.wall = vessel_wall;
    keys.min = {-0.05, 0.01, -0.03}, keys.max = {0.07, 0.09, 0.05};
    keys.from = {0.01, 0.02, 0}, keys.to = {0.01, 0.1, 0}, keys.radius = 0.06;
    if (kind == "sphere") keys.rim = 0.03;
    return keys;
}

/// Largest error of the distance, relative to `exact`, at random points around the shape.
template <class F>
double worst_distance(const Shape& shape, const F& exact, bool plane = false) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> at(-0.15, 0.15);
    double worst = 0;
    for (int k = 0; k < 2000; ++k) {
        const Vec3d x(at(random), at(random), plane ? 0 : at(random));
        worst = std::max(worst, std::abs(static_cast<double>(shape.distance(x.cast<Real>())) - exact(x)));
    }
    return worst;
}

/// The signed distance from a figure in the half-plane (s, h), by 1000 segments of each part of its boundary; `inside` gives the sign.
std::function<double(const Point2&)> distance_from_curve(const std::vector<std::function<Point2(double)>>& parts,
                                                         const std::function<bool(const Point2&)>& inside) {
    std::vector<std::pair<Point2, Point2>> boundary;
    for (const auto& part : parts)
        for (int k = 0; k < 1000; ++k) boundary.emplace_back(part(k / 1000.0), part((k + 1) / 1000.0));
    return [boundary, inside](const Point2& x) {
        double least = 1;
        for (const auto& [a, b] : boundary) {
            const Point2 along = b - a;
            least = std::min(least, (x - a - std::clamp((x - a).dot(along) / along.squaredNorm(), 0.0, 1.0) * along).squaredNorm());
        }
        return (inside(x) ? -1 : 1) * std::sqrt(least);
    };
}

std::function<Point2(double)> line(const Point2& a, const Point2& b) {
    return [=](double t) { return Point2(a + t * (b - a)); };
}

/// The distance from the walls of vessel_keys("box"), which are the union of five boxes, and from what is not wall.
double distance_from_walls(const Vec3d& x) {
    const ShapeKeys keys = vessel_keys("box");
    const Vec3d t = Vec3d::Constant(vessel_wall);
    Box3 outer(keys.min - t, keys.max + t), cavity(keys.min, keys.max);
    outer.max().y() = keys.max.y(), cavity.max().y() = 1;
    double outside = 1;
    for (int a = 0; a < 3; ++a)
        for (const bool high : {false, true}) {
            if (a == 1 && high) continue;
            Box3 part = outer;
            (high ? part.min() : part.max())[a] = (high ? keys.max : keys.min)[a];
            outside = std::min(outside, part.exteriorDistance(x));
        }
    if (outside > 0) return outside;
    return -std::min({cavity.exteriorDistance(x), (x - outer.min()).minCoeff(), (outer.max() - x).minCoeff()});
}

/// The same for a cavity that is a mesh: the outside is vessel_wall away from the five faces below the rim.
double distance_from_mesh_walls(const Vec3d& x, double rim) {
    const ShapeKeys keys = vessel_keys("box");
    Box3 cavity(keys.min, keys.max);
    cavity.max().y() = rim;
    const auto from_faces = [&](const Vec3d& at) {
        double least = 1;
        for (int a = 0; a < 3; ++a)
            for (const bool high : {false, true}) {
                if (a == 1 && high) continue;
                Box3 face = cavity;
                (high ? face.min() : face.max())[a] = (high ? cavity.max() : cavity.min())[a];
                least = std::min(least, face.exteriorDistance(at));
            }
        return least;
    };
    const double h = x.y() - rim, u = from_faces(x);
    const Vec3d foot(x.x(), std::min(x.y(), rim), x.z());
    const bool above_cavity = cavity.contains(foot);
    if (above_cavity) return u;
    if (h <= 0) return u > vessel_wall ? u - vessel_wall : -std::min({u, vessel_wall - u, -h});
    return std::hypot(h, std::max(0.0, from_faces(foot) - vessel_wall));
}

}  // namespace

TEST_CASE("the signed distance of an open vessel is exact within 1e-6 m, also above its rim", "[geometry][vessel]") {
    CHECK(worst_distance(*make_shape(vessel_keys("box")), distance_from_walls) < 1e-6);
    const double t = vessel_wall, r = 0.06, R = r + t, H = 0.08;

    const auto cylinder = distance_from_curve(
        {line({0, -H}, {r, -H}), line({r, -H}, {r, 0}), line({r, 0}, {R, 0}), line({R, 0}, {R, -H - t}), line({R, -H - t}, {0, -H - t})},
        [&](const Point2& x) { return x.y() <= 0 && x.y() >= -H - t && x.x() <= R && (x.x() >= r || x.y() <= -H); });
    CHECK(worst_distance(*make_shape(vessel_keys("cylinder")), [&](const Vec3d& x) {
              return cylinder({std::hypot(x.x() - 0.01, x.z()), x.y() - 0.1});
          }) < 1e-6);

    for (const double rim : {0.03, -0.02}) {
        ShapeKeys keys = vessel_keys("sphere");
        keys.rim = rim;
        const auto arc = [=](double radius) {
            const double end = std::acos(-rim / radius);
            return [=](double part) { return Point2(radius * std::sin(end * part), -radius * std::cos(end * part)); };
        };
        const auto sphere =
            distance_from_curve({arc(r), arc(R), line({std::sqrt(r * r - rim * rim), rim}, {std::sqrt(R * R - rim * rim), rim})},
                                [=](const Point2& x) { return x.norm() >= r && x.norm() <= R && x.y() <= rim; });
        CHECK(worst_distance(*make_shape(keys), [&](const Vec3d& x) { return sphere({std::hypot(x.x(), x.z()), x.y()}); }) < 1e-6);
        keys.cut = true;
        CHECK(worst_distance(
                  *make_shape(keys),
                  [&](const Vec3d& x) {
                      return sphere({std::abs(x.x()), x.y()});
                  },
                  true) < 1e-6);
    }
    // A mesh has the same cavity whether its lid is at the rim or above it.
    const std::shared_ptr<const Shape> cavity = make_mesh(make_box(vessel_keys("box").min, vessel_keys("box").max)->mesh(0, 0), "box");
    for (const double rim : {0.09, 0.08})
        CHECK(worst_distance(*make_mesh_vessel(cavity, Vec3d::UnitY(), rim, t),
                             [&](const Vec3d& x) { return distance_from_mesh_walls(x, rim); }) < 1e-6);
}

TEST_CASE("vessels that open at any side are turned copies of each other", "[geometry][vessel]") {
    const std::shared_ptr<const Shape> up = make_shape(vessel_keys("sphere"));
    for (const std::string& open : openings()) {
        ShapeKeys keys = vessel_keys("sphere", open);
        const Vec3d n = opening_direction(open);
        keys.rim = 0.03 * n.sum();
        const Mat3d turn = Eigen::Quaterniond::FromTwoVectors(Vec3d::UnitY(), n).toRotationMatrix();
        CHECK(worst_distance(*make_shape(keys), [&](const Vec3d& x) {
                  return static_cast<double>(up->distance((turn.transpose() * x).cast<Real>()));
              }) < 1e-6);
        Vec3 min, max;
        make_shape(keys)->bounds(min, max);
        CHECK(max.cast<double>().dot(n.cwiseAbs()) == Approx(n.sum() > 0 ? 0.03 : 0.08));
    }
}

TEST_CASE("a vessel's normal is the gradient of its distance, its mesh encloses its volume, and its samples cover both sides",
          "[geometry][vessel]") {
    const std::shared_ptr<const Shape> cavity = make_mesh(make_sphere({0, 0, 0}, 0.06)->mesh(Real(0.003), 0), "ball");
    const std::shared_ptr<const Shape> vessels[] = {make_shape(vessel_keys("box")), make_shape(vessel_keys("cylinder")),
                                                    make_shape(vessel_keys("sphere")),
                                                    make_mesh_vessel(cavity, Vec3d::UnitY(), 0.03, vessel_wall)};
    std::mt19937 random(5);
    std::uniform_real_distribution<double> at(-0.12, 0.12);
    for (const auto& vessel : vessels) {
        INFO(&vessel - vessels);
        int bent = 0;
        for (int k = 0; k < 1000; ++k) {
            const Vec3 x = Vec3d(at(random), at(random), at(random)).cast<Real>(), n = vessel->normal(x);
            REQUIRE(n.norm() == Approx(1).margin(1e-4));
            bent += std::abs(vessel->distance(x + Real(1e-4) * n) - vessel->distance(x) - Real(1e-4)) > Real(3e-6);
        }
        CHECK(bent < 20);  // points at which two surfaces are equally near
        const TriangleMesh mesh = vessel->mesh(Real(0.003), 0);
        CHECK(bulk_of(mesh).volume == Approx(vessel->bulk().volume).epsilon(3e-3));  // facets of a round mesh
        int turned = 0;
        for (const auto& [a, b, c] : mesh.triangle)
            turned += (mesh.position[b] - mesh.position[a])
                          .cross(mesh.position[c] - mesh.position[a])
                          .dot(mesh.normal[a] + mesh.normal[b] + mesh.normal[c]) < 0;
        CHECK(turned == 0);

        // Samples half a spacing deep, about a spacing apart, with the normal of the nearer side: their areas add up to the surface's.
        constexpr Real d = Real(0.005);
        const SamplingRegion region{d, {Vec3::Constant(Real(-0.2)), Vec3::Constant(Real(0.2)), {}}, 3 * d, false};
        const auto samples = vessel->surface_samples(-d / 2, region);
        double area = 0;
        for (const auto& t : mesh.triangle)
            area +=
                static_cast<double>((mesh.position[t[1]] - mesh.position[t[0]]).cross(mesh.position[t[2]] - mesh.position[t[0]]).norm()) /
                2;
        CHECK(static_cast<double>(samples.size()) == Approx(area / (0.005 * 0.005)).epsilon(0.15));
        for (const SurfaceSample& s : samples) {
            const Vec3 x = s.position.cast<Real>();
            if (!s.concave) REQUIRE(vessel->distance(x) > Real(-0.65) * d);
            REQUIRE(vessel->distance(x) < 0);  // at the edges of a mesh it is less deep than half a spacing
            REQUIRE(s.outward.norm() == Approx(1).margin(1e-4));
            REQUIRE(vessel->distance((s.position + 0.006 * s.outward).cast<Real>()) > 0);
        }
    }
}
