#include "engine/io/diagnostics.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include "engine/core/parallel.h"
#include "engine/io/csv.h"
#include "engine/models/coupled/coupled_system.h"

namespace whorl {
namespace {

/// The sums that one pass over the particles makes: u (3), x cross u (3), w (3), count, compression.
using Sums = Eigen::Array<double, 11, 1>;

}  // namespace

double filled_volume(Span<const Vec3> x, const Domain& domain, const Solids& solids, Real d) {
    constexpr Real near = 1.3f, far = 2;
    const int dimensions = domain.dimensions();
    const Real flat = dimensions == 2 ? Real(0.55) : Real(0.6);
    Vec3 low = Vec3::Constant(std::numeric_limits<Real>::max()), high = -low, edge = Vec3::Ones();
    for (const Vec3& p : x) low = low.cwiseMin(p), high = high.cwiseMax(p);
    if (x.empty() || !low.allFinite() || !high.allFinite()) return 0;
    if (dimensions == 2) low[2] = Real(-0.5);
    int cells[3] = {1, 1, 1}, reach[3] = {0, 0, 0};
    double count = 1;
    for (int a = 0; a < dimensions; ++a) {
        if (domain.periodic[a]) low[a] = domain.min[a], high[a] = domain.max[a];
        else low[a] -= far * d, high[a] += far * d;
        cells[a] = static_cast<int>(std::clamp(std::ceil(2 * double(high[a] - low[a]) / double(d)), 1.0, 1e6));
        edge[a] = (high[a] - low[a]) / static_cast<Real>(cells[a]);
        reach[a] = static_cast<int>(std::ceil(far * d / edge[a]));
        count *= cells[a];
    }
    if (count > 1e7 + 100 * static_cast<double>(x.size())) return 0;
    const auto cell_of = [&](const Vec3& p, int a) { return std::clamp(static_cast<int>((p[a] - low[a]) / edge[a]), 0, cells[a] - 1); };
    const auto centre = [&](int a, int b, int c) {
        return Vec3(low + edge.cwiseProduct(Vec3(Real(a), Real(b), Real(c)) + Vec3::Constant(Real(0.5))));
    };
    const auto wrapped = [&](int cell, int a) { return domain.periodic[a] ? (cell + cells[a]) % cells[a] : cell; };
    std::vector<std::vector<Index>> sheets(static_cast<std::size_t>(cells[0]));  // particles by their cell along x
    for (std::size_t i = 0; i < x.size(); ++i) sheets[static_cast<std::size_t>(cell_of(x[i], 0))].push_back(static_cast<Index>(i));
    std::vector<double> filled(sheets.size(), 0);
    parallel_blocks(cells[0], 1, [&](Index a, Index) {
        std::vector<Real> nearest(static_cast<std::size_t>(cells[1]) * static_cast<std::size_t>(cells[2]), far * far * d * d);
        for (int k = -reach[0]; k <= reach[0]; ++k) {
            const int from = wrapped(a - k, 0);
            if (from < 0 || from >= cells[0]) continue;
            for (const Index i : sheets[static_cast<std::size_t>(from)]) {
                const int b = cell_of(x[i], 1), c = cell_of(x[i], 2);
                const Vec3 own = centre(from, b, c) - x[i];
                for (int l = -reach[1]; l <= reach[1]; ++l) {
                    const Real across = (own + edge.cwiseProduct(Vec3(Real(k), Real(l), 0))).head<2>().squaredNorm();
                    if (!(across < far * far * d * d)) continue;
                    for (int m = -reach[2]; m <= reach[2]; ++m) {
                        const Real along = own[2] + edge[2] * Real(m), r2 = across + along * along;
                        if (!(r2 < far * far * d * d)) continue;
                        const auto at = static_cast<std::size_t>(wrapped(b + l, 1)) * static_cast<std::size_t>(cells[2]) +
                                        static_cast<std::size_t>(wrapped(c + m, 2));
                        nearest[at] = std::min(nearest[at], r2);
                    }
                }
            }
        }
        Real distance = 0;  // from solids, at least
        for (std::size_t at = 0; at < nearest.size(); ++at) {
            const Real away = std::sqrt(nearest[at]) / d;
            const int b = static_cast<int>(at) / cells[2], c = static_cast<int>(at) % cells[2];
            distance = c == 0 ? 0 : distance - edge[2];
            if (!(away < far)) continue;
            if (distance < d / 4) solids.nearest(centre(a, b, c), distance);
            const Real open = std::clamp(Real(0.5) + 2 * distance / d, Real(0), Real(1));
            const auto within = [&](Real r) { return std::clamp(Real(0.5) + 2 * (r - away), Real(0), Real(1)); };
            filled[a] += double(open * (within(near) + (flat - near) / (far - near) * (within(far) - within(near))));
        }
    });
    double sum = 0;
    for (const double part : filled) sum += part;
    return sum * edge.cast<double>().prod() / (static_cast<double>(x.size()) * std::pow(double(d), dimensions));
}

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

double coupled_volume(const World& world) {
    if (!world.fluid.has<field::held>()) return 0;
    const auto x = world.fluid.column<field::position>();
    const auto role = world.fluid.column<field::role>();
    std::vector<Vec3> out;  // of the nozzles
    for (std::size_t k = 0; k < x.size(); ++k)
        if (role[k] >= 0) out.push_back(x[k]);
    return filled_volume(out, world.step.domain, world.solids, world.step.spacing);
}

std::string diagnostics_header() {
    return "frame,time,steps,particles,time_step,max_speed,kinetic_energy,potential_energy,spin_energy,momentum_x,momentum_y,momentum_z,"
           "angular_momentum_x,angular_momentum_y,angular_momentum_z,density_error_mean,density_error_max,pressure_iterations,"
           "viscosity_iterations,lost_particles,wall_seconds,cpu_seconds,gravity_work,torque_work,pressure_work,boundary_work,viscous_"
           "dissipation,"
           "exchange_dissipation,smoothing_dissipation,surface_tension_work,solid_work,force_work,moves_work,emitted_energy,drained_energy,"
           "energy_error,emitted_particles,drained_particles,volume";
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
    return row + "," + number(now.emitted_particles) + "," + number(now.drained_particles) + "," + (m.volume > 0 ? number(m.volume) : "") +
           "\n";
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
