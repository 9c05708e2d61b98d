#include "tests/support/solids.h"

#include <catch2/catch.hpp>
#include <numbers>

#include "engine/core/errors.h"
#include "engine/core/random.h"
#include "engine/geometry/plane.h"
#include "engine/geometry/shape.h"
#include "engine/models/pressure/density_rate.h"
#include "engine/particles/boundary_sampling.h"
#include "engine/particles/search.h"

using namespace whorl;
using test::solid_of;
using test::solids_of;

namespace {

VectorExpression expressions(const std::string& x, const std::string& y, const std::string& z) {
    return {{Expression(x), Expression(y), Expression(z)}};
}

Domain cube(Real half, std::array<bool, 3> periodic = {false, false, false}) {
    return {Vec3::Constant(-half), Vec3::Constant(half), periodic};
}

/// Smallest and largest distance of a particle to its nearest neighbour, over the spacing.
std::pair<double, double> gaps(const BoundaryParticles& particles, Real spacing, const Domain& domain) {
    Pairs pairs;
    NeighbourSearch().find(particles.position, 2 * spacing, domain, pairs);
    double least = 1e9, most = 0;
    for (Index i = 0; i < pairs.size(); ++i) {
        double nearest = 1e9;
        pairs.of(i, [&](Index, const Vec3&, Real distance) { nearest = std::min(nearest, double(distance)); });
        least = std::min(least, nearest / spacing);
        most = std::max(most, nearest / spacing);
    }
    return {least, most};
}

}  // namespace

TEST_CASE("a solid turns about its centre at a constant rate exactly", "[geometry]") {
    Solids solids = solids_of(make_box({0, 0, 0}, {2, 4, 2}));
    solids.all[0].spin = expressions("0", "0", "3");
    solids.all[0].position = expressions("0.5*t", "0", "0");
    solids.set_time(std::numbers::pi / 6, 1e-3);  // a quarter turn
    const Pose& pose = solids.all[0].pose;
    const Vec3 centre = pose.rotation * Vec3(1, 2, 1) + pose.translation;
    CHECK((centre - Vec3(Real(1 + std::numbers::pi / 12), 2, 1)).norm() < 1e-5);
    CHECK((pose.rotation * Vec3(1, 0, 0) - Vec3(0, 1, 0)).norm() < 1e-5);
    CHECK((pose.velocity_at(centre) - Vec3(Real(0.5), 0, 0)).norm() < 1e-3);
    CHECK((pose.angular_velocity - Vec3(0, 0, 3)).norm() < 1e-3);
    // Its long side lies along x.
    CHECK(solids.all[0].distance(centre + Vec3(Real(2.5), 0, 0)) == Approx(0.5).margin(1e-5));
    CHECK((solids.all[0].normal(centre + Vec3(Real(2.5), 0, 0)) - Vec3(1, 0, 0)).norm() < 1e-5);
}

TEST_CASE("a solid with a pivot swings about it like a pendulum, to 1e-6", "[geometry]") {
    Solids solids;
    solids.all.push_back(solid_of(make_box({0, 0, 0}, {2, 4, 2})));
    Solid& door = solids.all[0];
    door.own_pivot = Vec3d(0, 4, 1);
    door.spin = expressions("0", "0", "cos(t)");
    door.position = expressions("0", "t", "0");
    const double t = 0.7, angle = std::sin(t);
    solids.set_time(t, 1e-4);
    const Vec3d arm(std::cos(angle) * 1 + std::sin(angle) * 2, std::sin(angle) * 1 - std::cos(angle) * 2,
                    0);  // from the pivot to the middle
    const Vec3 middle = door.pose.rotation * Vec3(1, 2, 1) + door.pose.translation;
    CHECK((middle.cast<double>() - Vec3d(0, 4 + t, 1) - arm).norm() < 1e-6);
    CHECK((door.centre() - Vec3d(0, 4 + t, 1)).norm() < 1e-6);
    const Vec3d velocity = Vec3d(0, 1, 0) + Vec3d(0, 0, std::cos(t)).cross(arm);
    CHECK((door.pose.velocity_at(middle).cast<double>() - velocity).norm() < 3e-4);  // mean over the step of 1e-4 s
}

TEST_CASE("velocities reach the pose at the end of the step", "[geometry]") {
    Solids solids = solids_of(make_sphere({0.3, 0, 0}, 1));
    solids.all[0].position = expressions("sin(3*t)", "t^2", "0");
    solids.all[0].spin = expressions("cos(5*t)", "2*t", "1");
    const double t = 0.7, dt = 1e-3;
    for (const Vec3& own : {Vec3(Real(1.3), 0, 0), Vec3(Real(0.3), 1, 0), Vec3(0, 0, Real(0.9))}) {
        solids.set_time(t, dt);
        const Pose before = solids.all[0].pose;
        const Vec3 from = before.rotation * own + before.translation;
        solids.set_time(t + dt, dt);
        const Vec3 to = solids.all[0].pose.rotation * own + solids.all[0].pose.translation;
        // A rigid turn by w dt leaves the tangent by (w dt)^2/2 = 2e-6; float positions round by 1e-7.
        CHECK((from + Real(dt) * before.velocity_at(from) - to).norm() < 5e-6);
    }
}

TEST_CASE("a rotation by a time-dependent spin is bit-identical for any steps", "[geometry]") {
    const auto made = [] {
        Solids solids = solids_of(make_sphere({0, 0, 0}, 1));
        solids.all[0].spin = expressions("2*sin(3*t)", "t", "1-t");
        return solids;
    };
    Solids straight = made(), walked = made(), back = made();
    straight.set_time(1.2345, 1e-3);
    for (double t = 0; t < 1.2345; t += 0.00137) walked.set_time(t, 0.00137);
    walked.set_time(1.2345, 1e-3);
    back.set_time(5, 1e-3);
    back.set_time(1.2345, 1e-3);
    CHECK(straight.all[0].pose.rotation == walked.all[0].pose.rotation);
    CHECK(straight.all[0].pose.rotation == back.all[0].pose.rotation);
    CHECK(straight.all[0].pose.angular_velocity == walked.all[0].pose.angular_velocity);
    // About one axis the angle is the integral of the rate.
    Solids one = made();
    one.all[0].spin = expressions("0", "3*t^2", "0");
    one.set_time(1.1, 1e-3);
    const double angle = 1.1 * 1.1 * 1.1;
    CHECK((one.all[0].pose.rotation * Vec3(1, 0, 0) - Vec3(Real(std::cos(angle)), 0, Real(-std::sin(angle)))).norm() < 1e-6);
}

TEST_CASE("a container's distance is positive inside", "[geometry]") {
    Solid box = solid_of(make_box({-1, -1, -1}, {1, 1, 1}));
    box.inside = true;
    CHECK(box.distance(Vec3(0, 0, 0)) == Approx(1));
    CHECK(box.distance(Vec3(Real(0.75), 0, 0)) == Approx(0.25));
    CHECK((box.normal(Vec3(Real(0.75), 0, 0)) - Vec3(-1, 0, 0)).norm() < 1e-5);
    Solids solids;
    solids.all = {box, solid_of(make_sphere({0, 0, 0}, 0.2))};
    Real distance = 0;
    CHECK(solids.nearest(Vec3(Real(0.3), 0, 0), distance) == 1);
    CHECK(distance == Approx(0.1).epsilon(1e-4));
    CHECK(solids.nearest(Vec3(Real(0.9), 0, 0), distance) == 0);
}

TEST_CASE("every solid gets one layer half a spacing deep, without crowding or holes", "[geometry]") {
    const Real d = Real(0.05);
    const auto sphere_mesh = make_mesh(make_sphere({0, 0, 0}, 0.6)->mesh(Real(0.1), 1), "ball");
    const auto box_mesh = make_mesh(make_box({-0.5, -0.4, -0.3}, {0.5, 0.4, 0.3})->mesh(1, 1), "box");
    struct Case {
        std::string name;
        std::shared_ptr<const Shape> shape;
        double area;  // of the shape
        double least;
    };
    const double pi = std::numbers::pi;
    for (const Case& one : {Case{"box", make_box({-0.5, -0.4, -0.3}, {0.5, 0.4, 0.3}), 3.76, 0.95},
                            Case{"sphere", make_sphere({0, 0, 0}, 0.6), 4 * pi * 0.36, 0.7},
                            Case{"cylinder", make_cylinder({0, -0.5, 0}, {0.3, 0.4, 0}, 0.4), 2 * pi * 0.4 * (0.4 + std::sqrt(0.9)), 0.5},
                            Case{"mesh of a sphere", sphere_mesh, 4 * pi * 0.36, 0.79}, Case{"mesh of a box", box_mesh, 3.76, 0.79}})
        for (const bool inside : {false, true}) {
            INFO(one.name << (inside ? " as a container" : ""));
            Solids solids = solids_of(one.shape);
            solids.all[0].inside = inside;
            solids.set_time(0, 1e-3);
            const BoundaryParticles particles = sample_solids(solids, d, cube(2));
            for (Index s = 0; s < particles.size(); ++s) {
                const Vec3& x = particles.position[s];
                // Beyond the edges of a container the corners of the layer are further from the shape: sqrt(3)/2 spacings at most.
                REQUIRE(solids.all[0].distance(x) < -0.44 * d);
                REQUIRE(solids.all[0].distance(x) > -0.88 * d);
                REQUIRE(particles.normal[s].norm() == Approx(1).epsilon(1e-4));
                // Half a spacing along the normal is the surface.
                const Vec3 above = x + Real(0.9) * d * particles.normal[s];
                REQUIRE(solids.all[0].distance(above) > 0);
            }
            const auto [least, most] = gaps(particles, d, cube(2));
            CHECK(least > one.least);
            CHECK(most < 1.6);  // dart throwing fills every gap wider than twice 0.8 spacings
            // One particle per area d^2 of the layer. Half a spacing more or less at the rims is 10 % of the area of these bodies.
            CHECK(particles.size() == Approx(one.area / (d * d)).epsilon(0.2));
            // No hole: every point of the surface has a particle within little more than a spacing.
            const TriangleMesh surface = one.shape->mesh(Real(0.05), 1);
            std::vector<Vec3> points;
            for (const auto& t : surface.triangle)
                points.push_back(((surface.position[t[0]] + surface.position[t[1]] + surface.position[t[2]]) / 3).cast<Real>());
            Pairs near;
            NeighbourSearch().find(points, particles.position, Real(1.25) * d, cube(2), near);
            for (Index k = 0; k < near.size(); ++k) REQUIRE(near.count(k) > 0);
        }
}

TEST_CASE("on a plane the volumes are those of an infinite lattice, and periodic axes have no seam", "[geometry]") {
    const Real d = Real(0.1);
    Solids solids = solids_of(make_plane({0, 0, 0}, {0, 1, 0}));
    // 2.06 is no whole number of spacings: the lattice is fitted to the period.
    Domain domain{Vec3(Real(-1.03), -1, -1), Vec3(Real(1.03), 1, 1), {true, false, true}};
    const BoundaryParticles particles = sample_solids(solids, d, domain);
    CHECK(particles.size() == 21 * 20);
    // 1/sum W over an infinite lattice of 2.06/21 by 0.1 m.
    const CubicKernel W(2 * d);
    double sum = 0;
    for (int a = -3; a <= 3; ++a)
        for (int b = -3; b <= 3; ++b) sum += static_cast<double>(W.value(static_cast<Real>(std::hypot(a * 2.06 / 21, b * 0.1))));
    for (Real V : particles.volume) REQUIRE(V == Approx(1 / sum).epsilon(1e-3));
    for (const Vec3& x : particles.position) REQUIRE(x[1] == Approx(-d / 2));
    for (const Vec3& n : particles.normal) REQUIRE((n - Vec3(0, 1, 0)).norm() < 1e-6);

    // Inclined, periodic along z; and far outside the domain nothing is left.
    solids.all[0] = solid_of(make_plane({0, 0, 0}, {-1, 2, 0}));
    solids.set_time(0, 1e-3);
    const BoundaryParticles inclined = sample_solids(solids, d, domain);
    Domain along_z = domain;
    along_z.periodic = {false, false, true};
    const auto [least, most] = gaps(inclined, d, along_z);
    CHECK(least > 0.95);
    CHECK(most < 1.05);
    solids.all[0] = solid_of(make_plane({0, -7, 0}, {0, 1, 0}));
    solids.set_time(0, 1e-3);
    CHECK(sample_solids(solids, d, domain).size() == 0);
}

TEST_CASE("where a box stands on a wall, joined surfaces have no particle between them and no normal into the wall", "[geometry]") {
    const Real d = Real(0.1);
    StepContext step;
    step.spacing = d, step.support = 2 * d, step.domain = cube(2);
    Solids solids = solids_of(make_box({-1, -1, -1}, {1, 1, 1}));
    solids.all[0].inside = true;
    solids.all.push_back(solid_of(make_box({0, -1, -1}, {0.5, -0.5, -0.5})));
    solids.set_time(0, 1e-3);
    BoundaryParticles particles = sample_solids(solids, d, step.domain, step.kernel, step.support);
    join_surfaces(particles, solids, step);
    int on_faces = 0;
    for (Index s = 0; s < particles.size(); ++s) {
        const Vec3 x = particles.position[s], ahead = x + Real(0.75) * d * particles.normal[s];
        for (std::size_t k = 0; k < 2; ++k)
            if (static_cast<Index>(k) != particles.solid[s]) CHECK(solids.all[k].distance(ahead) > -d / 8);
        if (particles.solid[s] == 0) continue;
        CHECK(particles.normal[s].y() >= 0);  // it stands on y = -1, against z = -1
        CHECK(particles.normal[s].z() >= 0);
        on_faces += particles.normal[s].cwiseAbs().maxCoeff() > Real(0.99);
    }
    // 5 by 5 particles on each of the four free faces, without the five edges and corners at which two or three of them meet.
    CHECK(on_faces > 40);
}

TEST_CASE("a box through a periodic domain has no ends and no seam there", "[geometry]") {
    const Real d = Real(0.1);
    const Domain domain = cube(1, {true, false, false});
    for (const bool inside : {false, true}) {
        Solids solids = solids_of(make_box({-1, -0.5, -0.5}, {1, 0.5, 0.5}));
        solids.all[0].inside = inside;
        solids.set_time(0, 1e-3);
        const BoundaryParticles particles = sample_solids(solids, d, domain);
        CHECK(particles.size() == 20 * (inside ? 44 : 36));
        const auto [least, most] = gaps(particles, d, domain);
        CHECK(least == Approx(1).epsilon(1e-3));
        CHECK(most == Approx(1).epsilon(1e-3));
    }
}

TEST_CASE("a tilted solid has its layer everywhere inside the domain, and no farther out", "[geometry]") {
    const Real d = Real(0.1);
    Solids solids;
    const auto sampled = [&](std::shared_ptr<const Shape> shape, const Vec3d& tilt, const Domain& domain) {
        solids.all = {solid_of(std::move(shape))};
        solids.all[0].turn = turn_by(tilt).toRotationMatrix();
        solids.set_time(0, 1e-3);
        return sample_solids(solids, d, domain);
    };
    // An upright bar that is rotated into a flat domain equals one that was made lying.
    const Domain flat{Vec3(-2, -1, Real(-0.3)), Vec3(2, 1, Real(0.3)), {}};
    const BoundaryParticles laid = sampled(make_box({-0.1, -0.1, -1.5}, {0.1, 0.1, 1.5}), {0, std::numbers::pi / 2, 0}, flat);
    CHECK(laid.size() == sampled(make_box({-1.5, -0.1, -0.1}, {1.5, 0.1, 0.1}), {0, 0, 0}, flat).size());

    // A rod that crosses a periodic face keeps its far end.
    const Domain periodic = cube(1, {true, false, false});
    CHECK(sampled(make_cylinder({-0.3, 0, 0}, {1.5, 0, 0}, Real(0.1)), {0, 0, 0.7}, periodic).size() ==
          sampled(make_cylinder({-0.3, 0, 0}, {1.5, 0, 0}, Real(0.1)), {0, 0, 0}, periodic).size());

    // A wide slope: every point of it in the domain has a particle near by, and no particle is farther out than three spacings.
    const double slope = std::numbers::pi / 6;
    const Vec3 up(0, Real(-std::sin(slope)), Real(std::cos(slope)));
    const bool along_x = GENERATE(false, true);
    const Domain domain = cube(1, {along_x, false, false});
    for (const auto& shape : {make_box({-5, -5, -5}, {5, 5, 0}), make_plane({0, 0, 0}, {0, 0, 1})}) {
        const BoundaryParticles particles = sampled(shape, {slope, 0, 0}, domain);
        for (const Vec3& x : particles.position) REQUIRE((x.array().abs() < 1 + 3 * d + 1e-5).all());
        const Solid& solid = solids.all[0];
        RandomNumbers numbers(3);
        for (int n = 0; n < 2000; ++n) {
            Vec3 x(Real(2 * numbers() - 1), Real(2 * numbers() - 1), Real(2 * numbers() - 1));
            x -= solid.distance(x) * up;
            if (!(x.array().abs() < 1).all()) continue;
            Real nearest = 1;
            for (const Vec3& p : particles.position) nearest = std::min(nearest, domain.minimum_image(p - x).norm());
            REQUIRE(nearest < 0.95 * d);  // half a spacing deep, and half the diagonal of the lattice
        }
    }
}

TEST_CASE("a moving plane has boundary particles wherever it meets the domain, in the predicted number", "[geometry]") {
    const Real d = Real(0.2);
    struct Motion {
        Vec3d normal;
        VectorExpression position, spin;
        std::array<bool, 3> periodic;
    };
    const VectorExpression still;
    const auto [normal, position, spin, periodic] = GENERATE_COPY(
        Motion{{0, 1, 0}, expressions("0", "t-3", "0"), still, {}},
        Motion{{0, 1, 0}, expressions("0", "t-3", "0"), still, {true, false, true}},
        Motion{{1, 2, -1}, expressions("t-2", "t-2", "0"), still, {}}, Motion{{0, 1, 0}, expressions("2*t", "0", "0"), still, {}},
        Motion{{1, 1, 0}, expressions("0", "sin(3*t)-1", "0"), expressions("0", "0", "2*t"), {false, false, true}},
        Motion{{0, 1, 0}, expressions("0", "-0.5", "0"), expressions("1", "2", "0"), {}});
    const Domain domain = cube(1, periodic);
    Solids solids = solids_of(make_plane({0, 0, 0}, normal));
    Solid& solid = solids.all[0];
    solid.position = position, solid.spin = spin;
    solids.set_time(0, 1e-3);
    BoundaryParticles particles = sample_solids(solids, d, domain, {}, 0, {}, 4);
    CHECK(particles.size() == Approx(patch_of_moving_plane(solid, d, domain, 2 * d, 4).points()).epsilon(0.03));
    CHECK(gaps(particles, d, domain).first > 0.95);
    const auto before = [](const Vec3& a, const Vec3& b) { return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end()); };
    Column<Vec3> shorter = sample_solids(solids, d, domain, {}, 0, {}, 2).own_position, all = particles.own_position;
    std::sort(shorter.begin(), shorter.end(), before), std::sort(all.begin(), all.end(), before);
    CHECK(std::includes(all.begin(), all.end(), shorter.begin(), shorter.end(), before));
    RandomNumbers numbers(3);
    int met = 0;
    for (double t = 0; t <= 4; t += 0.25) {
        solids.set_time(t, 1e-3);
        particles.follow(solids);
        for (int n = 0; n < 100; ++n) {
            Vec3 x(Real(2 * numbers() - 1), Real(2 * numbers() - 1), Real(2 * numbers() - 1));
            x -= solid.distance(x) * solid.normal(x);
            if (!(x.array().abs() < 1).all()) continue;
            ++met;
            Real nearest = 1;
            for (const Vec3& p : particles.position) nearest = std::min(nearest, domain.minimum_image(p - x).norm());
            REQUIRE(nearest < 0.95 * d);
        }
    }
    CHECK(met > 100);
}

TEST_CASE("the layer of a rocking plane scales with the domain's section, not its length", "[geometry]") {
    const Real d = Real(0.05);
    const Domain domain{Vec3(0, 0, 0), Vec3(10, 1, Real(0.5)), {}};
    Solids solids = solids_of(make_plane({0, 0, 0}, {1, 0, 0}));
    const Index still = sample_solids(solids, d, domain).size();
    solids.all[0].spin = expressions("0", "0", "0.3*cos(5*t)");
    solids.set_time(0, 1e-3);
    const BoundaryParticles rocking = sample_solids(solids, d, domain, {}, 0, {}, 1);
    CHECK(rocking.size() >= still);
    CHECK(rocking.size() < 1.3 * still);
    for (const Vec3& u : rocking.velocity) REQUIRE(u.norm() < 0.3 * 1.5);
}

TEST_CASE("a layer of more than 50 million particles is refused with the solid's location", "[geometry]") {
    Solids solids = solids_of(make_plane({0, 0, 0}, {0, 1, 0}));
    const auto place_of = [](std::size_t) { return FileLocation{"scene.toml", 3, 9}; };
    CHECK_THROWS_WITH(sample_solids(solids, Real(1e-5), cube(10), {}, 0, place_of),
                      Catch::Matchers::StartsWith("scene.toml:3:9: solid[0]: the surface of the plane needs") &&
                          Catch::Matchers::Contains("million particles"));
}

TEST_CASE("the boundary particles of a wide box scale with its surface, not its volume", "[geometry]") {
    const SamplingRegion region{Real(1e-4), cube(100), 0, false};
    ShapeKeys plate;
    plate.min = {0, 0, 0}, plate.max = {30, 30, 0}, plate.cut = true;
    CHECK(make_shape(plate)->surface_samples(0, region).size() == 4 * 300000);
    const SamplingRegion coarse{Real(0.01), cube(100), 0, false};
    CHECK(make_box({0, 0, 0}, {0.1, 0.1, 30})->surface_samples(0, coarse).size() == 3001 * 121 - 2999 * 81);
}

TEST_CASE("particles follow their solid and carry its velocity", "[geometry]") {
    Solids solids = solids_of(make_sphere({1, 0, 0}, 0.5));
    solids.all[0].spin = expressions("0", "0", "2");
    solids.set_time(0, 1e-4);
    BoundaryParticles particles = sample_solids(solids, Real(0.1), cube(3));
    const Column<Real> volume = particles.volume;
    solids.set_time(0.4, 1e-4);
    particles.follow(solids);
    for (Index s = 0; s < particles.size(); ++s) {
        const Vec3 arm = particles.position[s] - Vec3(1, 0, 0);
        REQUIRE(arm.norm() == Approx(0.45).epsilon(1e-4));
        REQUIRE((particles.velocity[s] - Vec3(0, 0, 2).cross(arm)).norm() < 2e-3);
        REQUIRE(particles.normal[s].dot(arm) == Approx(0.45).epsilon(1e-3));
    }
}

TEST_CASE("in 2D distances and normals lie in the plane, and boundary particles on the outline", "[geometry][plane]") {
    ShapeKeys box, ball, rod;
    box.min = {0, 0, -1}, box.max = {0.4, 0.2, 3};
    ball.kind = "sphere", ball.centre = {1, 1, 0.3}, ball.radius = 0.5;  // cut to a radius of 0.4
    rod.kind = "cylinder", rod.from = {-1, 0, -2}, rod.to = {-1, 0, 1}, rod.radius = 0.3;
    box.cut = ball.cut = rod.cut = true;
    const auto rectangle = make_shape(box), disc = make_shape(ball), round = make_shape(rod);
    for (const Real z : {Real(0), Real(7)}) {
        CHECK(rectangle->distance(Vec3(Real(0.2), Real(0.1), z)) == Approx(-0.1));
        CHECK(rectangle->distance(Vec3(Real(0.43), Real(0.24), z)) == Approx(0.05));
        CHECK((rectangle->normal(Vec3(Real(0.43), Real(0.24), z)) - Vec3(Real(0.6), Real(0.8), 0)).norm() < 1e-5);
        CHECK(disc->distance(Vec3(1, Real(1.6), z)) == Approx(0.2));
        CHECK((round->normal(Vec3(Real(-0.9), 0, z)) - Vec3(1, 0, 0)).norm() < 1e-6);
    }
    CHECK(rectangle->bulk().volume == Approx(0.08));
    CHECK(disc->bulk().volume == Approx(std::numbers::pi * 0.16));
    // Inertia about its axis of a disc of 1 m depth: m r^2/2.
    CHECK(disc->bulk().inertia()(2, 2) == Approx(std::numbers::pi * 0.16 * 0.16 / 2));

    const Real d = Real(0.02);
    const Domain domain{Vec3(-3, -3, 0), Vec3(3, 3, 0), {}};
    for (const auto& [shape, length] : {std::pair{rectangle, 2 * (0.38 + 0.18)}, {disc, 2 * std::numbers::pi * 0.39}}) {
        Solids solids = solids_of(shape);
        const BoundaryParticles boundary = sample_solids(solids, d, domain, {KernelKind::cubic, 2}, 2 * d);
        CHECK(boundary.size() == std::lround(length / static_cast<double>(d)));
        const auto [least, most] = gaps(boundary, d, domain);
        CHECK(least > 0.95);
        CHECK(most < 1.05);
        for (Index s = 0; s < boundary.size(); ++s) {
            REQUIRE(boundary.position[s].z() == 0);
            REQUIRE(boundary.normal[s].z() == 0);
            REQUIRE(shape->distance(boundary.position[s]) == Approx(-0.01).epsilon(0.01));
        }
    }
    // A plane along z is a line.
    Solids ground = solids_of(make_plane({0, 0, 0}, {0, 1, 0}));
    const BoundaryParticles line = sample_solids(ground, d, domain, {KernelKind::cubic, 2}, 2 * d);
    CHECK(line.size() == Approx((6 + 6 * 0.02) / 0.02).margin(1));
    for (const Vec3& x : line.position) REQUIRE((x.z() == 0 && x.y() == Approx(-0.01)));
}

TEST_CASE("fluid on a lattice has its density within 0.2 % at faces, edges and corners of a box", "[geometry][solids]") {
    // sum_s V_s W(|r'_is|) of the constraint's images against the lattice, continued through the solids. Where three walls meet V_s is 15 %
    // too large on convex corners, which have fewer neighbours.
    const Real d = Real(0.1);
    const auto box = [](int dimensions, double low, double low_y, double high, double high_y) {
        ShapeKeys keys;
        keys.min = {low, low_y, low}, keys.max = {high, high_y, high}, keys.cut = dimensions == 2;
        return make_shape(keys);
    };
    for (const int dimensions : {2, 3}) {
        const KernelForm form{KernelKind::cubic, dimensions};
        const WallImage wall(form, 2 * d, d);
        const CubicKernel W(2 * d, dimensions);
        Solids solids = solids_of(box(dimensions, 0.3, 0.3, 0.7, 0.7));
        const BoundaryParticles boundary = sample_solids(solids, d, Domain{Vec3(-3, -3, -3), Vec3(3, 3, 3), {}}, form, 2 * d);
        const auto in_solid = [&](const Vec3& x) {
            return std::any_of(solids.all.begin(), solids.all.end(), [&](const Solid& solid) { return solid.distance(x) < 0; });
        };
        each_lattice_point(dimensions, 5, [&](int x, int y, int z) {
            const Vec3 at = d * Vec3(Real(x) + Real(4.5), Real(y) + Real(4.5), dimensions == 2 ? 0 : Real(z) + Real(4.5));
            if (in_solid(at)) return;
            Real lattice = 0, seen = 0;
            each_lattice_point(dimensions, 2, [&](int a, int b, int c) {
                const Vec3 to = d * Vec3(Real(a), Real(b), Real(c));
                if (in_solid(at + to)) lattice += std::pow(d, Real(dimensions)) * W.value(to.norm());
            });
            int corner = 0;
            for (Index s = 0; s < boundary.size(); ++s) {
                const Vec3 r = at - boundary.position[s];
                if (r.norm() < 2 * d) seen += wall.share(W, r, r.norm(), boundary, s).value;
                corner |= r.norm() < 2 * d && boundary.behind[s] == 0 && boundary.normal[s].cwiseAbs().minCoeff() > Real(0.5);
            }
            INFO(dimensions << "D, at " << at.transpose());
            CHECK(seen == Approx(lattice).margin(corner ? 0.015 : 0.002));
        });
    }
}

TEST_CASE("a mesh of any thickness has its layer on both sides, without holes", "[geometry]") {
    const double d = 0.05;
    for (const double thickness : {0.6, 0.3, 0.2, 0.1, 0.02}) {
        INFO(thickness);
        Solids solids = solids_of(make_mesh(make_box({0, 0, 0}, {1, thickness * d, 1})->mesh(0, 0), "plate"));
        const BoundaryParticles boundary = sample_solids(solids, static_cast<Real>(d), cube(2));
        for (const Real side : {Real(-1), Real(1)})
            for (double x = 0.05; x < 1; x += 0.09)
                for (double z = 0.05; z < 1; z += 0.09) {
                    double nearest = 1;
                    for (Index s = 0; s < boundary.size(); ++s) {
                        if (!(side * boundary.normal[s].y() > Real(0.5))) continue;
                        const Vec3& at = boundary.position[s];
                        nearest = std::min(nearest, std::hypot(static_cast<double>(at.x()) - x, static_cast<double>(at.z()) - z));
                    }
                    REQUIRE(nearest < d);  // dart throwing leaves no disc of .8 d empty
                }
    }
}
