#include "engine/io/diagnostics.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "engine/core/random.h"
#include "engine/geometry/plane.h"
#include "engine/geometry/shape.h"
#include "engine/io/csv.h"
#include "engine/io/snapshot.h"
#include "engine/probes/probes.h"
#include "tests/support/scratch.h"
#include "tests/support/threads.h"

using namespace whorl;

namespace {

/// n particles of 2 kg with spin. The particles in `inside` are still in a nozzle.
World some_fluid(Index n) {
    World world;
    for (const FieldInfo* info : {&field_info<field::position>(), &field_info<field::velocity>(), &field_info<field::spin>(),
                                  &field_info<field::density>(), &field_info<field::role>()})
        world.fluid.declare(*info, true);
    world.fluid.resize(n);
    world.step.mass = 2;
    world.step.rest_density = 1000;
    world.step.spacing = Real(0.1);
    world.step.support = Real(0.3);
    for (Index i = 0; i < n; ++i) {
        const auto a = static_cast<Real>(i);
        world.fluid.column<field::position>()[i] = Vec3(std::sin(a), std::cos(3 * a), a / static_cast<Real>(n));
        world.fluid.column<field::velocity>()[i] = Vec3(std::cos(a), 1, std::sin(2 * a));
        world.fluid.column<field::spin>()[i] = Vec3(0, 0, 3);
        world.fluid.column<field::density>()[i] = i % 2 == 0 ? 1010 : 900;
    }
    return world;
}

void set(World& world, std::size_t i, const Vec3& x, const Vec3& u) {
    world.fluid.column<field::position>()[i] = x;
    world.fluid.column<field::velocity>()[i] = u;
}

}  // namespace

TEST_CASE("diagnostics of three particles match hand calculation, without a particle in a nozzle", "[io][diagnostics]") {
    World world = some_fluid(4);
    set(world, 0, {1, 0, 0}, {0, 2, 0});
    set(world, 1, {0, 3, 0}, {1, 0, 0});
    set(world, 2, {0, 0, 1}, {0, 0, 1});
    set(world, 3, {9, 9, 9}, {9, 9, 9});
    world.fluid.column<field::role>()[3] = -1;
    const Measures m = measure(world, Vec3d(0, -10, 0), 0.5);
    CHECK(m.particles == 3);
    CHECK(m.max_speed == Approx(2));
    CHECK(m.kinetic_energy == Approx(2 * (4 + 1 + 1) / 2.0));
    CHECK(m.potential_energy == Approx(2 * 10 * 3));
    CHECK(m.spin_energy == Approx(3 * 2 * 0.5 * 9 / 2));
    CHECK((m.momentum - Vec3d(2, 4, 2)).norm() < 1e-12);
    // x cross u = (0,0,2) + (0,0,-3) + 0, spin part 0.5 * 3 * (0,0,3)
    CHECK((m.angular_momentum - Vec3d(0, 0, 2 * (2 - 3 + 4.5))).norm() < 1e-12);
    CHECK(m.density_error_mean == Approx(0.01 * 2 / 3).epsilon(1e-4));  // only compression counts; float densities
    CHECK(m.density_error_max == Approx(0.01).epsilon(1e-4));
}

TEST_CASE("a row of diagnostics is bit-identical for any number of threads", "[io][diagnostics]") {
    const World world = some_fluid(20011);
    CHECK(test::same_on_threads([&] { return diagnostics_row(1, 0.5, measure(world, Vec3d(0, -9.81, 0), 1), {}, {}, 0, 0); }));
}

TEST_CASE("diagnostics.csv has the documented columns, and a cell for each in every row", "[io][diagnostics]") {
    CHECK(diagnostics_header() ==
          "frame,time,steps,particles,time_step,max_speed,kinetic_energy,potential_energy,spin_energy,momentum_x,momentum_y,momentum_z,"
          "angular_momentum_x,angular_momentum_y,angular_momentum_z,density_error_mean,density_error_max,pressure_iterations,"
          "viscosity_iterations,lost_particles,wall_seconds,cpu_seconds,"
          "gravity_work,torque_work,pressure_work,boundary_work,viscous_dissipation,exchange_dissipation,smoothing_dissipation,surface_"
          "tension_work,solid_work,force_work,moves_work,emitted_energy,drained_energy,energy_error,emitted_particles,drained_particles,"
          "volume");
    RunTotals before, now;
    before.steps = 10, now.steps = 14;
    before.pressure_iterations = 100, now.pressure_iterations = 150;
    now.viscosity_iterations = 8, now.lost_particles = 3, now.last_step = 0.25, now.drained_particles = 7;
    CHECK(diagnostics_row(2, 0.125, Measures{}, before, now, 1.5, 2.5) ==
          "2,0.125,14,0,0.25,0,0,0,0,0,0,0,0,0,0,0,0,12.5,2,3,1.5,2.5,,,,,,,,,,,,,,,0,7,\n");
}

TEST_CASE("the volume column follows a pool squeezed by 3 % within 0.5 %, on and off a lattice, in 3D and 2D", "[io][diagnostics]") {
    const double d = 0.01;
    for (const int depth : {12, 1})
        for (const double jitter : {0.0, 0.2})
            for (const bool periodic : {true, false}) {
                const int across = depth > 1 ? 12 : 40, high = 10;
                Domain domain{Vec3(0, -1, 0), Vec3(Real(across * d), 1, Real(depth * d)), {periodic, false, periodic && depth > 1}};
                if (depth == 1) domain.min[2] = domain.max[2] = 0;
                Solids solids;
                solids.all.resize(1);
                solids.all[0].shape = make_box(Vec3d(0, 0, depth > 1 ? 0 : -1), d * Vec3d(across, 30, depth > 1 ? depth : 100));
                solids.all[0].inside = true;
                if (periodic) solids.all[0].shape = make_plane(Vec3d::Zero(), Vec3d(0, 1, 0)), solids.all[0].inside = false;
                else domain.min = Vec3(-1, -1, depth > 1 ? -1 : 0), domain.max = Vec3(1, 1, depth > 1 ? 1 : 0);
                double volume[2];
                for (const int squeezed : {0, 1}) {
                    RandomNumbers random(1);
                    const auto loose = [&] { return 0.5 + jitter * (2 * random() - 1); };
                    std::vector<Vec3> x;
                    for (int a = 0; a < across; ++a)
                        for (int b = 0; b < high; ++b)
                            for (int c = 0; c < depth; ++c) {
                                const double p = a + loose(), q = (squeezed > 0 ? 0.97 : 1) * (b + loose()), r = c + loose();
                                x.push_back((d * Vec3d(p, q, depth > 1 ? r : 0)).cast<Real>());
                            }
                    volume[squeezed] = filled_volume(x, domain, solids, Real(d));
                }
                CAPTURE(depth, jitter, periodic, volume[0], volume[1]);
                CHECK(volume[1] / volume[0] == Approx(0.97).margin(0.005));
                CHECK(volume[0] == Approx(1).margin(0.01));
            }
    CHECK(filled_volume({}, {}, {}, Real(d)) == 0);
}

TEST_CASE("a region probe counts, weighs and averages the particles inside its box", "[io][probe]") {
    World world = some_fluid(3);
    set(world, 0, {0.2f, 0.2f, 0.2f}, {1, 0, 0});
    set(world, 1, {0.4f, 0.2f, 0.2f}, {3, 0, 0});
    set(world, 2, {2, 0, 0}, {9, 9, 9});
    ProbeKeys keys;
    keys.kind = ProbeKind::region;
    keys.max = Vec3d(1, 1, 1);
    const auto probe = make_probe(keys, world);
    CHECK(csv_header(probe->columns()) ==
          "time,particles,mass,centroid_x,centroid_y,centroid_z,velocity_x,velocity_y,velocity_z,spin_x,spin_y,spin_z");
    CHECK(csv_lines(probe->rows(world, 0.5)).substr(0, 12) == "0.5,2,4,0.30");
    for (std::int16_t& role : world.fluid.column<field::role>()) role = -1;
    CHECK(csv_lines(probe->rows(world, 0.5)) == "0.5,0,0,,,,,,,,,\n");
}

TEST_CASE("a point probe is exact for constant fields, also at a free surface, and empty without fluid", "[io][probe]") {
    World world = some_fluid(200);
    for (std::size_t i = 0; i < 200; ++i) {
        const auto a = static_cast<Real>(i);
        set(world, i, Vec3(std::sin(a), std::sin(7 * a), std::abs(std::sin(3 * a))) * Real(0.25), {1, 2, 3});
        world.fluid.column<field::density>()[i] = 1000;
    }
    ProbeKeys keys;
    const auto probe = make_probe(keys, world);
    CHECK(csv_header(probe->columns()) == "time,velocity_x,velocity_y,velocity_z,density,spin_x,spin_y,spin_z");
    CHECK(csv_lines(probe->rows(world, 2)) == "2,1,2,3,1000,0,0,3\n");
    keys.at = Vec3d(5, 5, 5);
    CHECK(csv_lines(make_probe(keys, world)->rows(world, 2)) == "2,,,,,,,\n");
}

TEST_CASE("a line probe writes its points from end to end, one profile per frame", "[io][probe]") {
    const World world = some_fluid(100);
    ProbeKeys keys;
    keys.kind = ProbeKind::line;
    keys.to = Vec3d(0, 0, 2);
    keys.count = 3;
    const auto probe = make_probe(keys, world);
    CHECK(csv_header(probe->columns()).substr(0, 13) == "time,s,x,y,z,");
    const std::string rows = csv_lines(probe->rows(world, 1));
    CHECK(std::count(rows.begin(), rows.end(), '\n') == 3);
    CHECK(rows.find("\n1,1,0,0,1,") != std::string::npos);
    CHECK(rows.find("\n1,2,0,0,2,") != std::string::npos);
}

TEST_CASE("a nozzle's mesh is a closed tube with a volume, for round openings and slots in any direction", "[io][snapshot]") {
    EmitterShape opening;
    opening.radius = Real(0.005), opening.width = Real(0.02), opening.thickness = Real(0.004);
    for (const bool slot : {false, true})
        for (const Vec3& direction : {Vec3(0, -1, 0), Vec3(1, 0, 0), Vec3(Real(0.6), Real(-0.8), 0)}) {
            opening.slot = slot;
            opening.direction = direction;
            const TriangleMesh tube = nozzle_mesh(opening, Real(0.001), Real(0.004));
            double volume = 0;  // by the divergence theorem: positive where the triangles face outward
            Vec3d area = Vec3d::Zero();
            for (const auto& t : tube.triangle) {
                const Vec3d a = tube.position[t[0]].cast<double>(), b = tube.position[t[1]].cast<double>(),
                            c = tube.position[t[2]].cast<double>();
                volume += a.dot(b.cross(c)) / 6;
                area += (b - a).cross(c - a) / 2;
            }
            const double gap = 0.0005, wall = 0.00075, pi = 3.14159265;
            const double section = slot ? (0.02 + 2 * (gap + wall)) * (0.004 + 2 * (gap + wall)) - (0.02 + 2 * gap) * (0.004 + 2 * gap)
                                        : pi * (std::pow(0.005 + gap + wall, 2) - std::pow(0.005 + gap, 2));
            CHECK(volume == Approx(section * 0.004).epsilon(0.01));  // 64 segments: 0.16 % less than a circle
            CHECK(area.norm() < 1e-9);
        }
}
