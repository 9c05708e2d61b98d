// Probes of a flow: fields between particles, energy, vorticity, distance from an expected velocity.
#include <catch2/catch.hpp>
#include <numbers>

#include "engine/core/random.h"
#include "engine/probes/interpolation.h"
#include "engine/probes/probes.h"

using namespace whorl;

namespace {

constexpr double d = 0.1;

/// Uneven particles that fill a cube of ten spacings, or a sheet z = 0, with the velocity u(x).
World uneven_fluid(bool sheet, const std::function<Vec3d(const Vec3d&)>& u) {
    World world;
    world.fluid.declare(field_info<field::position>(), true);
    world.fluid.declare(field_info<field::velocity>(), true);
    world.step.spacing = static_cast<Real>(d);
    world.step.mass = 2;
    world.step.domain.min = Vec3::Constant(-10), world.step.domain.max = Vec3::Constant(10);
    RandomNumbers random(3);
    const auto place = [&](int k) { return (k + 0.5 + 0.4 * (random() - 0.5)) * d; };
    std::vector<Vec3> x;
    for (int k = 0; k < (sheet ? 1 : 10); ++k)
        for (int j = 0; j < 10; ++j)
            for (int i = 0; i < 10; ++i) {
                const double a = place(i), b = place(j);
                x.push_back(Vec3d(a, b, sheet ? 0 : place(k)).cast<Real>());
            }
    world.fluid.resize(x.size());
    for (std::size_t i = 0; i < x.size(); ++i) {
        world.fluid.column<field::position>()[i] = x[i];
        world.fluid.column<field::velocity>()[i] = u(x[i].cast<double>()).cast<Real>();
    }
    return world;
}

Vec3d velocity_of(const World& world, const Interpolation& at) {
    Vec3d sum = Vec3d::Zero();
    for (const Interpolation::Share& one : at.shares)
        sum += one.weight * world.fluid.column<field::velocity>()[one.particle].cast<double>();
    return sum;
}
Vec3d interpolated_velocity(const World& world, const Vec3d& at) { return velocity_of(world, interpolate(world, {at}).front()); }

}  // namespace

TEST_CASE("probes are exact for quadratic fields on uneven particles, at a face of the fluid and in a sheet", "[probe]") {
    for (const bool sheet : {false, true}) {
        const double depth = sheet ? 0 : 1;
        const auto u = [&](const Vec3d& x) {
            const double z = depth * x.z();
            return Vec3d(1 + x.x() * x.x() - x.y() * z, 2 - x.y() + 3 * x.x() * x.y(), z * z - 4 * x.y() * x.y());
        };
        World world = uneven_fluid(sheet, u);
        for (const Vec3d& at : {Vec3d(0.52, 0.47, depth * 0.5), Vec3d(0.5, 0, depth * 0.55), Vec3d(0.33, 1, depth * 0.5)}) {
            INFO(at.transpose());
            // Single precision, of which a face of the fluid costs two digits.
            CHECK((interpolated_velocity(world, at) - u(at)).norm() < 2e-5);
        }
        // Many points in one call equal single calls bit for bit, also outside and in periodic domains.
        const std::vector<Vec3d> points{{0.52, 0.47, depth * 0.5}, {0.02, 0.98, 0}, {1.04, 0.5, 0.1}, {0.5, 0.5, 9}};
        for (const bool repeats : {false, true}) {
            if (repeats) {
                world.step.domain.min = Vec3(Real(-0.05), Real(-0.05), -10), world.step.domain.max = Vec3(Real(1.05), Real(1.05), 10);
                world.step.domain.periodic = {true, true, false};
            }
            const std::vector<Interpolation> found = interpolate(world, points);
            REQUIRE(found.size() == points.size());
            for (std::size_t k = 0; k < points.size(); ++k) CHECK(velocity_of(world, found[k]) == interpolated_velocity(world, points[k]));
        }
    }
}

TEST_CASE("outside the fluid probes give the mean of near particles, and no value farther away", "[probe]") {
    World world = uneven_fluid(false, [](const Vec3d& x) { return Vec3d(1, x.x(), 0); });
    const Vec3d outside = interpolated_velocity(world, Vec3d(1.2, 0.5, 0.5));
    CHECK(outside.x() == Approx(1).epsilon(1e-6));
    CHECK(outside.y() > 0.8);
    CHECK(outside.y() < 1);
    CHECK(interpolate(world, {Vec3d(1.5, 0.5, 0.5)}).front().shares.empty());
    world.fluid.resize(1);
    const Vec3d alone = interpolated_velocity(world, world.fluid.column<field::position>()[0].cast<double>() + Vec3d(0.05, 0, 0));
    CHECK((alone - world.fluid.column<field::velocity>()[0].cast<double>()).norm() < 1e-6);
}

TEST_CASE("a flow probe measures energy, vorticity and the distance from the expected velocity", "[probe]") {
    World world = uneven_fluid(false, [](const Vec3d& x) { return Vec3d(-3 * x.y(), 3 * x.x(), 0); });
    ProbeKeys keys;
    keys.kind = ProbeKind::flow;
    keys.min = Vec3d(-1, -1, -1), keys.max = Vec3d(2, 2, 2);
    keys.expected = {{Expression("-2*t*y"), Expression("2*t*x"), Expression(0.0)}};
    const auto probe = make_probe(keys, world);
    const std::vector<double> row = probe->rows(world, 1).at(0);
    REQUIRE(row.size() == probe->columns().size());
    double square = 0;
    for (const Vec3& u : world.fluid.column<field::velocity>()) square += u.squaredNorm();
    CHECK(row[1] == 1000);
    CHECK(row[2] == Approx(square).epsilon(1e-6));  // half of a mass of 2
    CHECK(row[3] == Approx(6).epsilon(1e-3));
    CHECK(row[4] == Approx(36).epsilon(1e-3));
    CHECK(row[5] == Approx(square * 4 / 9).epsilon(1e-6));
    CHECK(row[6] == Approx(0.5).epsilon(1e-5));  // u is 1.5 times the expected velocity
    CHECK(std::isnan(probe->rows(world, 0).at(0)[6]));
    // In a box one period away, the expected velocity is that at positions in the box.
    world.step.domain.periodic = {true, true, true};
    keys.min.x() += 20, keys.max.x() += 20;
    keys.expected.component[1] = Expression("2*t*(x-20)");
    CHECK(make_probe(keys, world)->rows(world, 1).at(0)[6] == Approx(0.5).epsilon(1e-5));

    keys.min = Vec3d(5, 5, 5), keys.max = Vec3d(6, 6, 6);
    const std::vector<double> empty = make_probe(keys, world)->rows(world, 1).at(0);
    CHECK(empty[2] == 0);
    CHECK((std::isnan(empty[3]) && std::isnan(empty[5])));
}
