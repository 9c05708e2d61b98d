#include "engine/geometry/vessel.h"

#include <catch2/catch.hpp>
#include <functional>
#include <numbers>
#include <random>

#include "engine/core/errors.h"
#include "engine/geometry/mesh_file.h"

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

/// The vessel around the mesh of the closed shape, with the wall and the rim of the keys. @param edge requested edge length of the mesh [m]
std::shared_ptr<const Shape> mesh_vessel(const ShapeKeys& keys, double rim, Real edge) {
    ShapeKeys closed = keys;
    closed.open = "none";
    return make_mesh_vessel(make_mesh(make_shape(closed)->mesh(edge, 0), "cavity"), Vec3d::UnitY(), rim, *keys.wall);
}

/// A prism from y = 0 to `height` over the polygon in the plane (z, x).
TriangleMesh prism(const std::vector<Point2>& polygon, float height) {
    TriangleMesh mesh;
    std::vector<Vec3d> x;
    std::vector<std::uint32_t> ring;
    const auto n = static_cast<std::uint32_t>(polygon.size());
    for (const bool top : {false, true})
        for (const Point2& at : polygon)
            mesh.position.emplace_back(static_cast<float>(at.y()), top ? height : 0, static_cast<float>(at.x()));
    for (std::uint32_t k = 0; k < n; ++k) {
        const std::uint32_t next = (k + 1) % n;
        mesh.triangle.push_back({k, next, n + next}), mesh.triangle.push_back({k, n + next, n + k});
        x.push_back(mesh.position[k].cast<double>()), ring.push_back(k);
    }
    const std::size_t sides = mesh.triangle.size();
    triangulate(x, ring, mesh.triangle);
    for (std::size_t t = sides, end = mesh.triangle.size(); t < end; ++t) {
        auto& [a, b, c] = mesh.triangle[t];
        mesh.triangle.push_back({n + a, n + b, n + c});
        std::swap(b, c);
    }
    return mesh;
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
    for (const double lid : {0.09, 0.1}) {
        ShapeKeys keys = vessel_keys("box");
        keys.max.y() = lid;
        CHECK(worst_distance(*mesh_vessel(keys, 0.09, 0), distance_from_walls) < 1e-6);
    }
}

TEST_CASE("the vessel of a mesh has the outside and the mass of the same vessel without a mesh", "[geometry][vessel]") {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> at(-0.15, 0.15);
    for (const double size : {0.1, 1.0, 30.0})
        for (const std::string kind : {"box", "cylinder", "sphere"})
            for (const int sides : size == 1 ? std::vector<int>{64, 128} : std::vector<int>{64}) {
                ShapeKeys keys = vessel_keys(kind);
                for (Vec3d* x : {&keys.min, &keys.max, &keys.from, &keys.to}) *x *= size;
                keys.radius *= size, *keys.wall *= size;
                if (keys.rim) *keys.rim *= size;
                const double rim = kind == "box" ? keys.max.y() : kind == "cylinder" ? keys.to.y() : *keys.rim;
                const std::shared_ptr<const Shape> exact = make_shape(keys);
                const auto mesh = mesh_vessel(keys, rim, static_cast<Real>(2 * std::numbers::pi * keys.radius / sides));
                INFO(kind << " of " << sides << " sides, times " << size);
                // The middles of a round mesh's faces and edges lie inside the round shape: by r angle^2/2 along each of two directions.
                const double angle = kind == "box" ? 0 : std::numbers::pi / sides, inset = keys.radius * angle * angle + 2e-7 * size;
                CHECK(mesh->bulk().volume == Approx(exact->bulk().volume).epsilon(angle * angle + 1e-4));
                double worst = 0, turn = 0;
                for (int k = 0; k < 500; ++k) {
                    const Vec3 x = (size * Vec3d(at(random), at(random), at(random))).cast<Real>();
                    const double distance = exact->distance(x);
                    worst = std::max(worst, std::abs(mesh->distance(x) - distance));
                    // Fluid that runs down outside meets the same wall.
                    if (distance > 0 && x.y() < rim && x.norm() > 0.08 * size)
                        turn = std::max(turn, (mesh->normal(x) - exact->normal(x)).cast<double>().norm());
                }
                CHECK(worst < inset);
                CHECK(turn < 2 * angle + 2e-3);
            }
}

TEST_CASE("the vessel of a concave mesh has sharp edges outside, and no wall in its cavity", "[geometry][vessel]") {
    // Two shafts, joined at one side; the gap between them is narrower than the wall.
    const std::vector<Point2> polygon{{0, 0}, {0.1, 0}, {0.1, 0.06}, {0.055, 0.06}, {0.055, 0.03}, {0.045, 0.03}, {0.045, 0.06}, {0, 0.06}};
    const double t = vessel_wall, H = 0.05;
    const auto cavity = make_mesh(prism(polygon, static_cast<float>(H)), "cavity");
    const auto vessel = make_mesh_vessel(cavity, Vec3d::UnitY(), H, t);
    const Box3 outer(Vec3d(-t, -t, -t), Vec3d(0.06 + t, H, 0.1 + t));
    CHECK(vessel->bulk().volume == Approx(outer.volume() - H * (0.1 * 0.06 - 0.01 * 0.03)).epsilon(1e-2));  // sampled, as walls overlap
    std::mt19937 random(9);
    std::uniform_real_distribution<double> at(-0.05, 0.15);
    int wrong = 0;
    for (int k = 0; k < 5000; ++k) {
        const Vec3d x(at(random), at(random), at(random));
        const double distance = vessel->distance(x.cast<Real>()), in_cavity = cavity->distance(x.cast<Real>());
        const bool in_wall = outer.contains(x) && in_cavity > 0;
        wrong += std::abs(distance) > 1e-6 && (distance < 0) != in_wall;
        if (!outer.contains(x) && x.y() < H) wrong += std::abs(distance - outer.exteriorDistance(x)) > 1e-6;
    }
    CHECK(wrong == 0);
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
