// Probes of what experiments measure: level of the surface, flux through an opening, extent of the fluid, pressure on a wall.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <numbers>
#include <sstream>

#include "engine/core/random.h"
#include "engine/geometry/shape.h"
#include "engine/particles/boundary_sampling.h"
#include "engine/probes/experiments.h"
#include "tests/support/runs.h"
#include "tests/support/scene_text.h"
#include "tests/support/solids.h"

using namespace whorl;

namespace gauges_test {
namespace {

constexpr double d = 0.1;

/// Particles at these positions, of volume d^D each.
World world_of(const std::vector<Vec3d>& places, int dimensions = 3) {
    World world;
    world.fluid.declare(field_info<field::position>(), true);
    world.fluid.declare(field_info<field::velocity>(), true);
    world.fluid.declare(field_info<field::role>(), true);
    world.fluid.declare(field_info<field::id>(), true);
    world.step.kernel.dimensions = dimensions;
    world.step.spacing = static_cast<Real>(d);
    world.step.volume = static_cast<Real>(std::pow(d, dimensions));
    world.step.mass = 1000 * world.step.volume;
    world.step.domain.min = Vec3::Constant(-10), world.step.domain.max = Vec3::Constant(10);
    world.fluid.resize(places.size());
    for (std::size_t k = 0; k < places.size(); ++k) {
        world.fluid.column<field::position>()[k] = places[k].cast<Real>();
        world.fluid.column<field::id>()[k] = static_cast<std::int32_t>(k);
    }
    return world;
}

/// Lattice points of a box that `inside` keeps, each moved by up to `jitter` spacings; in 2D those of z = 0.
template <class Inside>
std::vector<Vec3d> lattice(const Vec3d& size, int dimensions, double jitter, const Inside& inside) {
    RandomNumbers random(5);
    std::vector<Vec3d> places;
    for (double x = d / 2; x < size.x(); x += d)
        for (double y = d / 2; y < size.y(); y += d)
            for (double z = d / 2; z < (dimensions == 2 ? d : size.z()); z += d) {
                const Vec3d at(x, y, dimensions == 2 ? 0 : z);
                if (!inside(at)) continue;
                const Vec3d off = jitter * d * Vec3d(2 * random() - 1, 2 * random() - 1, dimensions == 2 ? 0 : 2 * random() - 1);
                places.push_back(at + off);
            }
    return places;
}

void add_box(World& world, const Vec3d& min, const Vec3d& max, bool inside) {
    ShapeKeys keys;
    keys.min = min, keys.max = max, keys.cut = world.step.dimensions() == 2;
    Solid solid = test::solid_of(make_shape(keys));
    solid.inside = inside;
    world.solids.all.push_back(solid);
    world.solids.set_time(0, 1);
}

double level(const World& world, const Vec3d& from, const Vec3d& to) {
    ProbeKeys keys;
    keys.kind = ProbeKind::level;
    keys.from = from, keys.to = to;
    return make_probe(keys, world)->rows(world, 0).at(0).at(1);
}

ProbeKeys flux_keys(const Vec3d& at, const Vec3d& direction) {
    ProbeKeys keys;
    keys.kind = ProbeKind::flux;
    keys.at = at, keys.direction = direction;
    return keys;
}

/// Moves every particle by its velocity and calls the probe.
void step(World& world, Probe& probe, double dt, double end) {
    world.step.dt = static_cast<Real>(dt);
    const auto x = world.fluid.column<field::position>();
    const auto u = std::as_const(world).fluid.column<field::velocity>();
    for (std::size_t k = 0; k < x.size(); ++k) x[k] = world.step.domain.wrapped(x[k] + world.step.dt * u[k]);
    probe.after_step(world, end);
}

}  // namespace

// The probe is accurate to half a spacing. On a lattice the kernel sums are exact to some hundredths of that.
TEST_CASE("the level of still water is within half a spacing in the middle, at walls and in corners", "[probe]") {
    for (const int dimensions : {2, 3})
        for (const double jitter : {0.0, 0.3})
            for (const double depth : {0.6, 1.0, 1.3}) {
                World world = world_of(lattice(Vec3d(2, depth, 2), dimensions, jitter, [](const Vec3d&) { return true; }), dimensions);
                const double z = dimensions == 2 ? 0 : 1, tolerance = (jitter > 0 ? 0.35 : 0.1) * d;
                CHECK(std::abs(level(world, {1, 0.3, z}, {1, 3, z}) + 0.3 - depth) < tolerance);
                CHECK(std::abs(level(world, {1, 0, z}, {1, 3, z}) - depth) < tolerance);
                add_box(world, Vec3d(0, 0, dimensions == 2 ? -9 : 0), Vec3d(2, 5, dimensions == 2 ? 9 : 2), true);
                for (const double x : {0.0, 0.02, 0.1, 1.0, 2.0}) {
                    INFO(dimensions << " dimensions, jitter " << jitter << ", depth " << depth << ", x " << x);
                    CHECK(std::abs(level(world, {x, 0, z}, {x, 3, z}) - depth) < tolerance);
                    // In edges the sum over the solids adds a tenth of a spacing.
                    if (dimensions == 3) CHECK(std::abs(level(world, {x, 0, 0.01}, {x, 3, 0.01}) - depth) < tolerance + d / 10);
                    CHECK(std::abs(level(world, {x, -0.5, z}, {x, 3, z}) - 0.5 - depth) < tolerance);  // begins under the floor
                }
                CHECK(level(world, {1, 0, z}, {1, 0.5, z}) == Approx(0.5));  // the line ends in water
                CHECK(level(world, {1, depth + 0.5, z}, {1, 4, z}) == 0);    // and begins above it
                const double thick = dimensions == 2 ? 9 : 2;
                add_box(world, Vec3d(-1, depth, -thick), Vec3d(3, 9, thick), false);  // full to a ceiling, over a floor of 9 m
                CHECK(std::abs(level(world, {1, 0, z}, {1, 4, z}) - depth) < tolerance + d / 4);
                world.solids.all.back() = world.solids.all.front(), world.fluid.resize(0);
                CHECK(level(world, {1, -3, z}, {1, 4, z}) == 0);  // a dry floor
            }
}

TEST_CASE("the level follows tilted surfaces and waves to half a spacing", "[probe]") {
    const double k = 2 * std::numbers::pi / 2;  // a wave of 20 spacings
    const auto tilted = [](double x) { return 0.8 + 0.4 * x; };
    const auto wave = [&](double x) { return 1 + 0.15 * std::sin(k * x); };
    const auto check = [&](const auto& surface, int dimensions) {
        const auto below = [&](const Vec3d& at) { return at.y() < surface(at.x()); };
        const World world = world_of(lattice(Vec3d(4, 4, 1), dimensions, 0, below), dimensions);
        const double z = dimensions == 2 ? 0 : 0.5;
        for (double x = 1; x < 3; x += 0.13) {
            INFO(dimensions << " dimensions, x " << x);
            CHECK(std::abs(level(world, {x, 0.2, z}, {x, 4, z}) + 0.2 - surface(x)) < d / 2);
        }
    };
    for (const int dimensions : {2, 3}) check(tilted, dimensions), check(wave, dimensions);
}

TEST_CASE("the level ignores drops above the water and over a dry floor, and passes a solid", "[probe]") {
    for (const int dimensions : {2, 3}) {
        const double z = dimensions == 2 ? 0 : 0.5;
        const auto wet = [](const Vec3d& at) { return at.y() < 1; };
        const auto drops = [&](const Vec3d& at) {
            return (at - Vec3d(0.5, 1.5, z)).norm() < 0.22 || (at - Vec3d(0.5, 1.9, z)).norm() < 0.1;
        };
        World world = world_of(lattice(Vec3d(1, 3, 1), dimensions, 0, [&](const Vec3d& at) { return wet(at) || drops(at); }), dimensions);
        CHECK(std::abs(level(world, {0.5, 0.2, z}, {0.5, 3, z}) + 0.2 - 1) < d / 10);
        CHECK(level(world_of(lattice(Vec3d(1, 3, 1), dimensions, 0, drops), dimensions), {0.5, 0, z}, {0.5, 3, z}) == 0);
        const auto about_pipe = [&](const Vec3d& at) { return wet(at) && std::hypot(at.x() - 0.5, at.y() - 0.5) > 0.2; };
        world = world_of(lattice(Vec3d(1, 3, 1), dimensions, 0, about_pipe), dimensions);
        CHECK(level(world, {0.5, 0.05, z}, {0.5, 3, z}) < 0.35);  // a hole in the fluid ends the search
        world.solids.all.push_back(test::solid_of(make_cylinder({0.5, 0.5, -9}, {0.5, 0.5, 9}, 0.2)));
        world.solids.set_time(0, 1);
        CHECK(std::abs(level(world, {0.5, 0.05, z}, {0.5, 3, z}) + 0.05 - 1) < d / 4);
    }
}

// Rows of particles cross at known times: the totals are whole numbers of particles, exactly.
TEST_CASE("a flux probe counts every path across its opening, signed, from disc to rectangle", "[probe]") {
    for (const int dimensions : {2, 3}) {
        World world = world_of(lattice(Vec3d(2, 2, 2), dimensions, 0.2, [](const Vec3d&) { return true; }), dimensions);
        const Vec3d at(1, 1, dimensions == 2 ? 0 : 1), along = Vec3d(0.6, 0.8, 0);
        for (Vec3& u : world.fluid.column<field::velocity>()) u = (2 * along).cast<Real>();
        ProbeKeys disc = flux_keys(at, along), rectangle = flux_keys(at, -along);
        disc.radius = 0.5, rectangle.width = 0.8, rectangle.thickness = 0.4;
        // Particles in the cylinder or the box swept over 0.3 m, counted by hand.
        double in_disc = 0, in_rectangle = 0;
        for (const Vec3& x : world.fluid.column<field::position>()) {
            const Vec3d r = x.cast<double>() - at;
            const double ahead = r.dot(along), aside = r.dot(Vec3d(-0.8, 0.6, 0));
            if (ahead >= 0 || ahead < -0.3) continue;
            in_disc += (r - ahead * along).norm() <= 0.5;
            in_rectangle += std::abs(dimensions == 2 ? aside : r.z()) <= 0.4 && (dimensions == 2 || std::abs(aside) <= 0.2);
        }
        REQUIRE(in_rectangle > 10);
        const auto one = make_probe(disc, world), other = make_probe(rectangle, world);
        CHECK(std::isnan(one->rows(world, 0).at(0).at(1)));
        for (int k = 1; k <= 15; ++k) {
            step(world, *one, 0.01, 0.01 * k);
            other->after_step(world, 0.01 * k);
        }
        const std::vector<double> row = one->rows(world, 0.15).at(0), back = other->rows(world, 0.15).at(0);
        const double volume = std::pow(d, dimensions);
        CHECK(row[3] == Approx(in_disc * volume).epsilon(1e-6));
        CHECK(row[4] == Approx(1000 * in_disc * volume).epsilon(1e-6));
        CHECK(row[1] == Approx(row[3] / 0.15).epsilon(1e-6));
        CHECK(back[3] == Approx(-in_rectangle * volume).epsilon(1e-6));

        // A loaded probe continues unchanged.
        std::stringstream state;
        one->save(state);
        const auto resumed = make_probe(disc, world);
        resumed->load(state);
        step(world, *one, 0.02, 0.17);
        resumed->after_step(world, 0.17);
        CHECK(one->rows(world, 0.17) == resumed->rows(world, 0.17));
        // Back the whole way: nothing is left.
        for (Vec3& u : world.fluid.column<field::velocity>()) u = -u;
        for (int k = 0; k < 17; ++k) step(world, *one, 0.01, 0.18 + 0.01 * k);
        CHECK(std::abs(one->rows(world, 1).at(0).at(3)) < 1e-12);
    }
}

TEST_CASE("a flux probe counts across periodic faces, ignores nozzles, and includes drained particles", "[probe]") {
    World world = world_of(lattice(Vec3d(1, 1, 1), 3, 0.2, [](const Vec3d&) { return true; }));
    world.step.domain.min = Vec3::Zero(), world.step.domain.max = Vec3::Ones(), world.step.domain.periodic = {true, true, true};
    for (Vec3& x : world.fluid.column<field::position>()) x = world.step.domain.wrapped(x);
    for (Vec3& u : world.fluid.column<field::velocity>()) u = Vec3(1, Real(0.35), Real(-0.2));
    ProbeKeys keys = flux_keys(Vec3d(0, 0.5, 0.5), Vec3d(1, 0, 0));  // on the face, over all of it
    keys.width = 1, keys.thickness = 1;
    const auto probe = make_probe(keys, world);
    for (int k = 1; k <= 40; ++k) step(world, *probe, 0.05, 0.05 * k);
    CHECK(probe->rows(world, 2).at(0).at(3) == Approx(2).epsilon(1e-6));  // around twice

    world = world_of({{-0.05, 0, 0}, {-0.05, 0.1, 0}, {-0.05, 0.2, 0}});
    for (Vec3& u : world.fluid.column<field::velocity>()) u = Vec3(1, 0, 0);
    world.fluid.column<field::role>()[0] = -1;
    keys = flux_keys(Vec3d(0, 0, 0), Vec3d(1, 0, 0));
    keys.radius = 0.5;
    const auto counting = make_probe(keys, world);
    world.step.dt = Real(0.1);
    world.fluid.column<field::position>()[0].x() = world.fluid.column<field::position>()[1].x() = Real(0.05);
    world.fluid.gather(std::vector<Index>{1, 0});  // the third is removed, the others change places
    counting->after_step(world, 0.1);
    CHECK(counting->rows(world, 0.1).at(0).at(3) == Approx(2 * d * d * d).epsilon(1e-6));
}

TEST_CASE("the extent is that of the connected fluid, without separated drops", "[probe]") {
    for (const int dimensions : {2, 3}) {
        std::vector<Vec3d> places = lattice(Vec3d(1.2, 0.7, 0.9), dimensions, 0, [](const Vec3d&) { return true; });
        ProbeKeys keys;
        keys.kind = ProbeKind::extent;
        keys.axis_point = Vec3d(0.2, 0, dimensions == 2 ? 0 : 0.45);
        keys.direction = Vec3d(1, 0, 0);
        const auto measured = [&] {
            const World world = world_of(places, dimensions);
            return make_probe(keys, world)->rows(world, 0).at(0);
        };
        const std::vector<double> block = measured();
        CHECK(block[1] == Approx(1.0));
        // The outermost particle is half a spacing from both faces.
        CHECK(block[2] == Approx(d / 2 + (dimensions == 2 ? 0.95 : std::hypot(0.95, 0.4))));
        CHECK(block[3] == Approx(0.7));
        for (const Vec3d& spray : {Vec3d(1.5, 0.05, 0), Vec3d(3, 0.05, 0), Vec3d(3.1, 0.05, 0), Vec3d(0.5, 2, 0)}) places.push_back(spray);
        CHECK(measured() == block);
        keys.direction = Vec3d(-1, 0, 0);
        CHECK(measured()[1] == Approx(0.2));
        World world = world_of(places, dimensions);
        for (std::int16_t& role : world.fluid.column<field::role>()) role = -1;
        CHECK(std::isnan(make_probe(keys, world)->rows(world, 0).at(0)[1]));
    }
    World ring = world_of(lattice(Vec3d(1, 0.5, 1), 3, 0, [](const Vec3d& at) { return at.x() < 0.3 || at.x() > 0.7; }));
    ring.step.domain.min = Vec3::Zero(), ring.step.domain.max = Vec3(1, 9, 1), ring.step.domain.periodic = {true, false, false};
    ProbeKeys keys;
    keys.kind = ProbeKind::extent;
    keys.axis_point = Vec3d(0, 0, 0.5);
    keys.direction = Vec3d(1, 0, 0);
    CHECK(make_probe(keys, ring)->rows(ring, 0).at(0)[1] == Approx(0.3));  // both parts are one, across the face
}

// Known impulses on the boundary particles of a wall, a separate lattice. The gauge measures their sum over the disc, divided by its area.
// For a varying pressure the error is a few per cent of the change over the disc, because particles lie unevenly about the middle.
TEST_CASE("a gauge reads the mean pressure on its disc over all steps, and the peak of one step", "[probe]") {
    for (const int dimensions : {2, 3}) {
        World world = world_of({}, dimensions);
        add_box(world, Vec3d(0, 0, dimensions == 2 ? -9 : 0), Vec3d(2, 2, dimensions == 2 ? 9 : 2), true);
        BoundaryParticles& boundary = world.boundary_particles;
        boundary = sample_solids(world.solids, world.step.spacing, world.step.domain, world.step.kernel, Real(0.3));
        double apart = 1;
        for (Index s = 0; s < boundary.size(); ++s)
            for (Index o = 0; o < s; ++o)
                if (std::min(boundary.normal[s].x(), boundary.normal[o].x()) > 0.9 && std::abs(boundary.position[s].y() - 1) < 0.3)
                    apart = std::min(apart, static_cast<double>((boundary.position[s] - boundary.position[o]).norm()));
        const double area = std::pow(apart, dimensions - 1);
        const auto press = [&](Probe& gauge, double dt, double factor) {
            world.step.dt = static_cast<Real>(dt);
            boundary.pressed.clear();
            for (Index s = 0; s < boundary.size(); ++s) {
                const double p = factor * (1000 - 400 * static_cast<double>(boundary.position[s].y()));
                boundary.pressed.push_back(-dt * p * area * boundary.normal[s].cast<double>());
            }
            gauge.after_step(world, 0);
        };
        ProbeKeys keys;
        keys.kind = ProbeKind::gauge;
        for (const double height : {0.5, 0.63, 1.2})
            for (const double radius : {0.15, 0.3, 0.5}) {
                INFO(dimensions << " dimensions, height " << height << ", radius " << radius);
                keys.at = Vec3d(0, height, dimensions == 2 ? 0 : 0.9), keys.radius = radius;
                const auto gauge = make_probe(keys, world), resumed = make_probe(keys, world);
                CHECK(std::isnan(gauge->rows(world, 0).at(0).at(1)));
                press(*gauge, 0.1, 1), press(*gauge, 0.3, 3);
                std::stringstream state;
                gauge->save(state);
                resumed->load(state);
                const std::vector<double> row = gauge->rows(world, 0.4).at(0);
                const double there = 1000 - 400 * height;
                CHECK(row[1] == Approx(2.5 * there).margin(0.03 * 2.5 * 400 * 2 * radius + 0.01 * 2.5 * there));
                CHECK(row[2] == Approx(1.2 * row[1]).epsilon(1e-6));
                CHECK(resumed->rows(world, 0.4).at(0) == row);
            }
        keys.at = Vec3d(1, 1, dimensions == 2 ? 0 : 1), keys.radius = 0.2;
        CHECK_THAT(make_probe(keys, world)->fault(), Catch::Contains("meets no surface of its solid, which is 1 m away"));
    }
}

// Gauges that tile a wall lose no force: their forces add up to the force of the wall's probe, except for the rims at its ends. The
// pressure depends on the models; here only its mean over the wall is compared with the weight above.
TEST_CASE("gauges that tile a wall add up to its force, for every 2D model", "[probe][sim]") {
    for (const std::string model : {"wcsph", "ppe"}) {
        std::string scene = test::text::time(0.3, "fps = 10") + test::text::domain({-0.02, -0.02}, {0.12, 0.2}) + test::text::fluid(5e-3) +
                            test::text::models(model) + test::text::block({0, 0}, {0.1, 0.08}) + test::text::plane({0, 0}, {0, 1}) +
                            test::text::plane({0, 0}, {1, 0}) + test::text::box({0.1, -0.02}, {0.12, 0.2}) +
                            "[[probe]]\nname = \"wall\"\nkind = \"solid\"\nsolid = 1\n";
        for (int k = 0; k < 4; ++k)
            scene += fmt::format("[[probe]]\nname = \"g{}\"\nkind = \"gauge\"\nsolid = 1\nat = [0, {}]\nradius = 0.0125\n", k,
                                 0.0125 + 0.025 * k);
        Simulation simulation = test::simulation_of(scene);
        NamedProbes probes = make_probes(simulation, TheorySearch::wait);
        std::vector<std::vector<double>> rows;
        for (const double until : {0.1, 0.3}) {
            while (simulation.time() < until) {
                REQUIRE_FALSE(simulation.step(until).diverged);
                for (const auto& [name, probe] : probes) probe->after_step(simulation.world(), simulation.time());
            }
            rows.clear();
            for (const auto& [name, probe] : probes) rows.push_back(rows_of(*probe, simulation).at(0));
        }
        double sum = 0;
        for (std::size_t k = 1; k < rows.size(); ++k) sum -= 0.025 * rows[k][1];
        INFO(model << ": " << rows[1][1] << ", " << rows[2][1] << ", " << rows[3][1] << ", " << rows[4][1] << " Pa");
        CHECK(sum == Approx(rows[0][1]).epsilon(0.05));
        CHECK(rows[1][1] > rows[2][1]);
        CHECK(rows[2][1] > rows[3][1]);
        CHECK(rows[1][2] >= rows[1][1]);
    }
}

}  // namespace gauges_test
