// Right-hand side of the coupled solve: the volume that the step requests, known pressures, loads.
#include <algorithm>
#include <numbers>

#include "engine/core/parallel.h"
#include "engine/models/viscosity/coupled/coupled_step.h"

namespace whorl {

/// Sets the curvature in the directions that the neighbours resolve; 0 for particles that are not free, whose motion is prescribed.
void CoupledStep::set_curvature() {
    curvature.resize(n);
    parallel_for(n, [&](Index i) {
        curvature[i].setZero();
        if (role[i] != 0) return;
        curvature[i] = curvature_strain(G[i], dt);
        if (system.rows.neighbourhood[i].unresolved > 0) {
            const Mat3 P = system.rows.resolved(i);
            curvature[i] = P * curvature[i] * P;
        }
    });
}

/// Factor on the rate c = push/dt at which compressed particles separate. The push changes the multiplier too. In short steps the sum of
/// both drives the fluid up and down as a whole: with the depth H, k = pi/(2 H) and B = lambda + 2 mu, the amplitude grows if c exceeds B
/// k^2/rho. Bodies would follow it, so around bodies c is at most half of that. H follows from the largest pressure.
double CoupledStep::share_of_push() const {
    const double density = static_cast<double>(step.rest_density), weight = density * static_cast<double>(step.gravity.norm());
    if (!bodies.any() || !(weight > 0)) return 1;
    const double depth = parallel_max(n, 0.0, [&](Index i) { return static_cast<double>(p[i]); }) / weight + static_cast<double>(d);
    const double thinness = parallel_sum(n, [&](Index i) { return 1 / static_cast<double>(mu[i]); }) / static_cast<double>(n);
    const double k = std::numbers::pi / (2 * depth), stable = (options.bulk + 2) / thinness * k * k / density;
    return std::min(1.0, stable / 2 / (options.push / static_cast<double>(dt)));
}

/// Sets the requested rate of volume change, s_i. Compressed particles separate. Loose particles under pressure approach, as far as the
/// options allow. Otherwise s_i = tr T keeps the volume, because the rate of volume change in the middle of the move is tr D - tr T.
void CoupledStep::set_divergence() {
    divergence.resize(n);
    const double fastest_push = options.fastest_push * (fastest / d + std::sqrt(step.gravity.norm() / d));
    const double share = share_of_push();
    const double meeting = system.rows.dimensions() == 2 ? 1 : options.meeting_in_space;
    const auto loose = [&](const Neighbourhood& around, double lacking) {
        if (options.vessel < 0) return meeting * lacking * std::clamp(2 - around.surface / options.no_surface, 0.0, 1.0);
        const double surface = std::min(static_cast<double>(around.surface), options.even_surface);
        return std::min(0.0, lacking + 0.85 * std::max(0.0, surface - options.no_surface));  // without the deficit of a surface
    };
    parallel_for(n, [&](Index i) {
        const Neighbourhood& around = system.rows.neighbourhood[i];
        double compressed = around.density - 1;
        // Fluid under tension is never drawn together, because a thread would creep without end.
        if (compressed < 0) compressed = p[i] > 0 ? loose(around, compressed) : 0;
        const double most = last_rate.empty() ? fastest_push : std::min(fastest_push, options.push_of_shear * last_rate[i]);
        const double pushed = starts ? 0 : std::clamp(share * (options.push * compressed / dt), -most, most);
        divergence[i] = static_cast<Real>(pushed) + curvature[i].trace();
    });
}

void CoupledStep::set_pressure() {
    pressure.resize(n);
    const std::vector<Real>& known_pressure = *system.known_pressure;
    const bool any_known = known_pressure.size() == x.values.size();
    parallel_for(n, [&](Index i) {
        pressure[i] = form.coefficients(i).bulk * d * divergence[i] +
                      system.rows.neighbourhood[i].volume * dt * (p[i] + (any_known ? known_pressure[i] : 0)) / (step.rest_density * d);
    });
}

/// Corrects the force of the pressure in a vessel that turns. Its fluid has the pressure p_0 = rho (level + g.x + rate^2 r^2/2), with
/// the rate from the fluid's angular momentum. The force -grad p_0 has errors in the rows of disordered particles and next to walls,
/// which would drive a vortex that lifts the edge. Away from surfaces (c < 0.2, fading to 0.4; the surface of a lattice has 0.31) the
/// load gets the exact force instead.
void CoupledStep::balance() {
    if (options.vessel < 0) return;
    using Eigen::Vector2d;
    const auto mean = [&](const auto& of) {  // (sum of the first component)/(sum of the second)
        const Vector2d sum = parallel_sum(n, Vector2d(0, 0), [&](Index i) { return role[i] == 0 ? of(i) : Vector2d(0, 0); });
        return static_cast<Real>(sum[1] > 0 ? sum[0] / sum[1] : 0.0);
    };
    const auto inside = [&](Index i) { return std::clamp(2 - system.rows.neighbourhood[i].surface / Real(0.2), Real(0), Real(1)); };
    VesselRotation& rotation = system.rotation;
    rotation = {solids.all[options.vessel].centre().cast<Real>(), -step.gravity.normalized()};
    const auto arm = [&](Index i) { return rotation.arm(x[i]); };
    const Real rate = rotation.rate = mean([&](Index i) { return Vector2d(arm(i).dot(u[i]), arm(i).squaredNorm()); });
    const auto height = [&](Index i) { return step.gravity.dot(x[i]) + rate * rate * arm(i).squaredNorm() / 2; };
    const Real level = mean([&](Index i) { return Vector2d(inside(i) * (p[i] / step.rest_density - height(i)), inside(i)); });
    Column<Real> q(n);
    balancing.resize(n);
    parallel_for(n, [&](Index i) {
        q[i] = system.rows.neighbourhood[i].volume * dt / d * std::max(Real(0), height(i) + level);
        balancing[i] = dt * (step.gravity - rotation.acceleration(x[i]));
    });
    form.add_stress(q, {}, balancing);
    parallel_for(n, [&](Index i) { balancing[i] *= -inside(i); });
}

/// Sets the right-hand side.
/// @returns the reference for its residual: the norm of the loads on the fluid, without the large forces by which nozzles and solids
/// hold their neighbours. It is at least 3 % of the norm with these forces, for a fluid at rest that only moving solids drag along
double CoupledStep::set_load() {
    parallel_for(n, [&](Index i) { load[i] = loaded(i, u[i]); });
    bodies.momenta(Span<Vec3>(load).subspan(static_cast<std::size_t>(n)));
    form.add_stress(pressure, curvature, load);
    unknowns.restrict_to(load);
    const double reference = preconditioned_norm(load);
    if (nothing_held) return reference;
    form.apply(known, work, true);
    unknowns.restrict_to(work);
    parallel_for(static_cast<Index>(entries), [&](Index i) { load[i] -= work[i]; });
    return std::max(reference, 0.03 * preconditioned_norm(load));
}

/// Frees the arrays that the load now includes, unless release_slipping() or a ledger needs them.
void CoupledStep::let_go() {
    if (!system.rows.any_slip && !writes_ledgers()) Column<Mat3>().swap(curvature), Column<Real>().swap(pressure);
}

}  // namespace whorl
