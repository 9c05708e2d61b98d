#include "engine/io/diagnostics.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <utility>

#include "engine/core/parallel.h"
#include "engine/io/csv.h"
#include "engine/models/temperature/temperature.h"
#include "engine/models/viscosity/coupled/coupled_system.h"

namespace whorl {
namespace {

/// Sums from one pass over the particles: u (3), x cross u (3), w (3), count, compression.
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
        Real distance = 0;  // lower bound of the distance from solids
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

std::optional<HeatMeasures> measure_heat(const World& world, const HeatLaw& law) {
    const ParticleStore& fluid = world.fluid;
    if (!fluid.has<field::temperature>()) return {};
    const auto T = fluid.column<field::temperature>();
    const auto role = fluid.column<field::role>();
    const Span<const Real> rest = fluid.has<field::temperature_rest>() ? fluid.column<field::temperature_rest>() : Span<const Real>();
    const auto at = [&](Index i) { return static_cast<double>(T[i]) + (rest.empty() ? 0 : static_cast<double>(rest[i])); };
    const auto sum = [&](const auto& f) { return parallel_sum(fluid.size(), [&](Index i) { return role[i] >= 0 ? f(i) : 0.0; }); };
    const auto most = [&](double sign) {
        return sign * parallel_max(fluid.size(), -std::numeric_limits<double>::infinity(),
                                   [&](Index i) { return role[i] >= 0 ? sign * at(i) : -std::numeric_limits<double>::infinity(); });
    };
    const double count = sum([](Index) { return 1.0; });
    if (!(count > 0)) return HeatMeasures{0, NAN, NAN, NAN};
    return HeatMeasures{static_cast<double>(world.step.mass) * sum([&](Index i) { return law.enthalpy(at(i)); }), sum(at) / count, most(-1),
                        most(1)};
}

double coupled_volume(const World& world) {
    if (!world.fluid.has<field::held>()) return 0;
    const auto x = world.fluid.column<field::position>();
    const auto role = world.fluid.column<field::role>();
    std::vector<Vec3> out;  // particles outside nozzles
    for (std::size_t k = 0; k < x.size(); ++k)
        if (role[k] >= 0) out.push_back(x[k]);
    return filled_volume(out, world.step.domain, world.solids, world.step.spacing);
}

namespace {

/// Values with the names of their columns. NaN becomes an empty cell.
struct NamedRow {
    std::vector<std::string> names;
    std::vector<double> values;

    void add(std::initializer_list<std::pair<const char*, double>> columns) {
        for (const auto& [name, value] : columns) names.emplace_back(name), values.push_back(value);
    }
    void add(const std::string& name, const Vec3d& value) {
        for (int a = 0; a < 3; ++a) names.push_back(name + "xyz"[a]), values.push_back(value[a]);
    }
};

NamedRow diagnostics(int frame, double time, const Measures& m, const RunTotals& before, const RunTotals& now, double wall, double cpu) {
    const double steps = static_cast<double>(std::max(1L, now.steps - before.steps));
    NamedRow row;
    row.add({{"frame", frame}, {"time", time}, {"steps", now.steps}, {"particles", m.particles}, {"time_step", now.last_step}});
    row.add({{"max_speed", m.max_speed}, {"kinetic_energy", m.kinetic_energy}, {"potential_energy", m.potential_energy}});
    row.add({{"spin_energy", m.spin_energy}});
    row.add("momentum_", m.momentum);
    row.add("angular_momentum_", m.angular_momentum);
    row.add({{"density_error_mean", m.density_error_mean}, {"density_error_max", m.density_error_max}});
    row.add({{"pressure_iterations", (now.pressure_iterations - before.pressure_iterations) / steps}});
    row.add({{"viscosity_iterations", (now.viscosity_iterations - before.viscosity_iterations) / steps}});
    row.add({{"lost_particles", now.lost_particles}, {"wall_seconds", wall}, {"cpu_seconds", cpu}});
    const EnergyBudget& work = now.work;
    const auto known = [&](double joule) { return now.any_work ? joule : NAN; };
    row.add({{"gravity_work", known(work.gravity)}, {"torque_work", known(work.torque)}, {"pressure_work", known(work.pressure)}});
    row.add({{"boundary_work", known(work.boundary)}, {"viscous_dissipation", known(-work.viscosity)}});
    row.add({{"exchange_dissipation", known(-work.exchange)}, {"smoothing_dissipation", known(-work.smoothing)}});
    row.add({{"surface_tension_work", known(work.surface_tension)}, {"solid_work", known(work.solids)}});
    row.add({{"force_work", known(work.forces + work.lifted)}, {"moves_work", known(work.moves)}});
    row.add({{"emitted_energy", known(work.emitted)}, {"drained_energy", known(-work.drained)}});
    row.add({{"energy_error", known(work.error(m.energy()))}, {"emitted_particles", now.emitted_particles}});
    row.add({{"drained_particles", now.drained_particles}, {"volume", m.volume > 0 ? m.volume : NAN}});
    if (m.heat) row.add({{"heat", m.heat->total}, {"temperature_mean", m.heat->mean}});
    if (m.heat) row.add({{"temperature_min", m.heat->coldest}, {"temperature_max", m.heat->hottest}});
    return row;
}

NamedRow body_row(int frame, double time, std::size_t solid, const RigidBody& b, const Vec3d& gravity) {
    const Vec3d p = b.mass * b.velocity;
    NamedRow row;
    row.add({{"frame", frame}, {"time", time}, {"solid", solid}});
    row.add("", b.centre);
    row.add({{"turn_w", b.turn.w()}});
    row.add("turn_", b.turn.vec());
    row.add("velocity_", b.velocity);
    row.add("angular_velocity_", b.angular_velocity());
    row.add("momentum_", p);
    row.add("angular_momentum_", b.centre.cross(p) + b.spin_momentum);  // about the origin
    row.add({{"kinetic_energy", b.kinetic_energy()}, {"potential_energy", -b.mass * gravity.dot(b.centre)}});
    return row;
}

}  // namespace

std::string diagnostics_header(bool heat) {
    Measures measures;
    if (heat) measures.heat.emplace();
    return csv_header(diagnostics(0, 0, measures, {}, {}, 0, 0).names);
}

std::string diagnostics_row(int frame, double time, const Measures& m, const RunTotals& before, const RunTotals& now, double wall,
                            double cpu) {
    return csv_lines({diagnostics(frame, time, m, before, now, wall, cpu).values});
}

std::string bodies_header() { return csv_header(body_row(0, 0, 0, {}, Vec3d::Zero()).names); }

std::string bodies_rows(int frame, double time, const World& world, const Vec3d& gravity) {
    std::vector<std::vector<double>> rows;
    for (std::size_t k = 0; k < world.solids.all.size(); ++k)
        if (world.solids.all[k].body) rows.push_back(body_row(frame, time, k, *world.solids.all[k].body, gravity).values);
    return csv_lines(rows);
}

}  // namespace whorl
