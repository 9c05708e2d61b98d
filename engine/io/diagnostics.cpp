#include "engine/io/diagnostics.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <string_view>

#include "engine/core/parallel.h"
#include "engine/io/csv.h"

namespace whorl {
namespace {

/// The sums that one pass over the particles makes: u (3), x cross u (3), w (3), count, compression.
using Sums = Eigen::Array<double, 11, 1>;

}  // namespace

Measures measure(const World& world, const Vec3d& gravity, double micro_inertia) {
    const ParticleStore& fluid = world.fluid;
    const auto x = fluid.column<field::position>();
    const auto u = fluid.column<field::velocity>();
    const auto role = fluid.column<field::role>();
    const Span<const Vec3> spin = fluid.has<field::spin>() ? fluid.column<field::spin>() : Span<const Vec3>();
    const Span<const Real> density = fluid.has<field::density>() ? fluid.column<field::density>() : Span<const Real>();
    const auto counts = [&](std::size_t k) { return role[k] >= 0; };
    const auto compression = [&](std::size_t k) {
        return density.empty() ? 0.0 : std::max(0.0, static_cast<double>(density[k]) / static_cast<double>(world.step.rest_density) - 1);
    };

    const Sums sums = parallel_sum(fluid.size(), Sums(Sums::Zero()), [&](Index i) {
        const auto k = static_cast<std::size_t>(i);
        Sums s = Sums::Zero();
        if (!counts(k)) return s;
        const Vec3d xi = x[k].cast<double>(), ui = u[k].cast<double>();
        s.segment<3>(0) = ui.array();
        s.segment<3>(3) = xi.cross(ui).array();
        if (!spin.empty()) s.segment<3>(6) = spin[k].cast<double>().array();
        s[9] = 1, s[10] = compression(k);
        return s;
    });
    const double fastest = parallel_max(fluid.size(), 0, [&](Index i) {
        const auto k = static_cast<std::size_t>(i);
        return counts(k) ? u[k].cast<double>().squaredNorm() : 0.0;
    });

    const double m = static_cast<double>(world.step.mass);
    Measures all{energies_of(world, gravity, micro_inertia)};
    all.particles = static_cast<Index>(sums[9]);
    all.max_speed = std::sqrt(fastest);
    all.momentum = m * sums.segment<3>(0).matrix();
    all.angular_momentum = m * (sums.segment<3>(3) + micro_inertia * sums.segment<3>(6)).matrix();
    all.density_error_mean = sums[9] > 0 ? sums[10] / sums[9] : 0;
    all.density_error_max = parallel_max(fluid.size(), 0, [&](Index i) { return counts(i) ? compression(i) : 0.0; });
    return all;
}

std::string diagnostics_header() {
    return "frame,time,steps,particles,time_step,max_speed,kinetic_energy,potential_energy,spin_energy,momentum_x,momentum_y,momentum_z,"
           "angular_momentum_x,angular_momentum_y,angular_momentum_z,density_error_mean,density_error_max,pressure_iterations,"
           "viscosity_iterations,lost_particles,wall_seconds,cpu_seconds,gravity_work,torque_work,pressure_work,boundary_work,viscous_"
           "dissipation,"
           "exchange_dissipation,smoothing_dissipation,surface_tension_work,solid_work,force_work,moves_work,emitted_energy,drained_energy,"
           "energy_error,emitted_particles,drained_particles";
}

std::string diagnostics_row(int frame, double time, const Measures& m, const RunTotals& before, const RunTotals& now, double wall,
                            double cpu) {
    const double steps = static_cast<double>(std::max(1L, now.steps - before.steps));
    std::string row = std::to_string(frame);
    for (double value : {time,
                         static_cast<double>(now.steps),
                         static_cast<double>(m.particles),
                         now.last_step,
                         m.max_speed,
                         m.kinetic_energy,
                         m.potential_energy,
                         m.spin_energy,
                         m.momentum.x(),
                         m.momentum.y(),
                         m.momentum.z(),
                         m.angular_momentum.x(),
                         m.angular_momentum.y(),
                         m.angular_momentum.z(),
                         m.density_error_mean,
                         m.density_error_max,
                         (now.pressure_iterations - before.pressure_iterations) / steps,
                         (now.viscosity_iterations - before.viscosity_iterations) / steps,
                         static_cast<double>(now.lost_particles),
                         wall,
                         cpu})
        row += "," + number(value);
    const EnergyBudget& work = now.work;
    const double error = work.error(m.energy());
    for (double value : {work.gravity, work.torque, work.pressure, work.boundary, -work.viscosity, -work.exchange, -work.smoothing,
                         work.surface_tension, work.solids, work.forces + work.lifted, work.moves, work.emitted, -work.drained, error})
        row += now.any_work ? "," + number(value) : ",";
    return row + "," + number(now.emitted_particles) + "," + number(now.drained_particles) + "\n";
}

std::string bodies_header() {
    return "frame,time,solid,x,y,z,turn_w,turn_x,turn_y,turn_z,velocity_x,velocity_y,velocity_z,angular_velocity_x,angular_velocity_y,"
           "angular_velocity_z,"
           "momentum_x,momentum_y,momentum_z,angular_momentum_x,angular_momentum_y,angular_momentum_z,kinetic_energy,potential_energy";
}

std::string bodies_rows(int frame, double time, const World& world, const Vec3d& gravity) {
    std::string rows;
    for (std::size_t k = 0; k < world.solids.all.size(); ++k) {
        if (!world.solids.all[k].body) continue;
        const RigidBody& b = *world.solids.all[k].body;
        const Vec3d w = b.angular_velocity(), p = b.mass * b.velocity, L = b.centre.cross(p) + b.spin_momentum;  // about the origin
        rows += std::to_string(frame);
        for (double value : {time,
                             static_cast<double>(k),
                             b.centre.x(),
                             b.centre.y(),
                             b.centre.z(),
                             b.turn.w(),
                             b.turn.x(),
                             b.turn.y(),
                             b.turn.z(),
                             b.velocity.x(),
                             b.velocity.y(),
                             b.velocity.z(),
                             w.x(),
                             w.y(),
                             w.z(),
                             p.x(),
                             p.y(),
                             p.z(),
                             L.x(),
                             L.y(),
                             L.z(),
                             b.kinetic_energy(),
                             -b.mass * gravity.dot(b.centre)})
            rows += "," + number(value);
        rows += "\n";
    }
    return rows;
}

}  // namespace whorl
