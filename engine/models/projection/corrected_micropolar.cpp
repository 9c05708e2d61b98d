#include "engine/models/projection/corrected_micropolar.h"

#include "engine/core/parallel.h"

namespace whorl {

namespace {

Vec3 curl_of(const Mat3& G) { return {G(2, 1) - G(1, 2), G(0, 2) - G(2, 0), G(1, 0) - G(0, 1)}; }

}  // namespace

template <class Kernel>
EnergyWork CorrectedMicropolar::advance(const Kernel& W, const Surroundings& around, Read<field::role> role, Read<field::velocity> u,
                                        Update<field::acceleration> a, Write<field::spin_change> change, Read<field::spin> w) const {
    const ProjectionSystem& s = *system_;
    const MicropolarOptions& o = options_;
    const StepContext& step = around.step;
    const SolidParticles& layer = around.layer;
    const Real dt = step.dt, m = step.mass, b = 1 / step.rest_density;
    const Real lambda = static_cast<Real>(o.coupling), over_theta = static_cast<Real>(1 / o.micro_inertia);
    const Real alpha = o.part_a_step(o.smoothing_velocity, dt) / dt, beta = o.part_a_step(o.smoothing_spin, dt) / dt;
    const Real mu = static_cast<Real>(o.pair_viscosity), gamma = static_cast<Real>(o.spin_viscosity);
    const Real ahead = o.implicit_exchange ? 1 / (1 + 2 * lambda * b * dt * over_theta) : 1;
    const Real of_layer = s.any_walls ? layer_factor(step.kernel, step.support, step.spacing) : 0;
    const std::vector<char> slip = slips(around.solids);
    const bool any_torque = !torque_.is_zero();
    const Kernel whole(step.support, step.dimensions());
    const Real over_lattice = 1 / lattice_gradient(step.kernel, viscous_support * step.support, step.spacing);

    return parallel_sum(a.size(), EnergyWork{}, [&](Index i) -> EnergyWork {
        if (role[i] != 0) {
            change[i].setZero();
            return {};
        }
        const Vec3 own_u = u[i], own_w = w[i];
        DifferenceSums of_u = difference_sums(W, around.pairs, i, step.volume, u.data(), whole);
        DifferenceSums of_w = difference_sums(W, around.pairs, i, step.volume, w.data(), whole);
        const Mat3 G_u = of_u.gradient * s.viscous.correction[i], G_w = of_w.gradient * s.viscous.correction[i];
        Real trace = s.viscous.trace[i], trace_w = trace;
        Vec3 imbalance = s.viscous.imbalance[i], imbalance_w = imbalance;
        each_sticking_layer(W, s, around, i, of_layer, slip, [&](Index q, Real F, Real continued, const Vec3& to, Real distance) {
            of_u.laplacian += F * continued * (own_u - surface_velocity(around, q));
            trace -= F * distance * distance;
            imbalance += F * to;
            if (o.free_spin_walls) return;
            of_w.laplacian += F * continued * (own_w - around.solids.all[layer.solid[q]].pose.angular_velocity);
            trace_w -= F * distance * distance;
            imbalance_w += F * to;
        });
        const auto laplacian = [&](const Vec3& sum, Real moments, const Mat3& G, const Vec3& uneven) {
            if (s.near_surface[i]) return Vec3(2 * over_lattice * sum);
            return Vec3(2 * static_cast<Real>(step.dimensions()) / std::max(moments, Real(0.1)) * (sum - G * uneven));
        };
        const Vec3 viscous = mu * b * laplacian(of_u.laplacian, trace, G_u, imbalance), push = lambda * b * curl_of(G_w);
        const Vec3 smoothing = alpha * of_u.smooth, before = a[i];
        a[i] += viscous + push + smoothing;

        const Vec3 tau = any_torque ? Vec3(change[i]) : Vec3(Vec3::Zero());
        const Vec3 exchanged = lambda * b * (curl_of(G_u) - 2 * own_w);
        const Vec3 diffused = gamma * b * laplacian(of_w.laplacian, trace_w, G_w, imbalance_w);
        const Vec3 spin_smoothing = beta * of_w.smooth;
        change[i] = dt * (ahead * over_theta * (exchanged + diffused + tau) + spin_smoothing);

        // Each force at the mean of the velocities before and after the kick: their works then add up to what the kick does.
        const Vec3 u_mid = own_u + dt / 2 * a[i], w_mid = own_w + change[i] / 2;
        const double energy = static_cast<double>(m * dt), spin_energy = energy * static_cast<double>(ahead);
        EnergyWork work;
        work.gravity = energy * static_cast<double>(before.dot(u_mid));
        work.viscosity = energy * static_cast<double>(viscous.dot(u_mid)) + spin_energy * static_cast<double>(diffused.dot(w_mid));
        work.exchange = energy * static_cast<double>(push.dot(u_mid)) + spin_energy * static_cast<double>(exchanged.dot(w_mid));
        work.torque = spin_energy * static_cast<double>(tau.dot(w_mid));
        work.smoothing =
            energy * (static_cast<double>(smoothing.dot(u_mid)) + o.micro_inertia * static_cast<double>(spin_smoothing.dot(w_mid)));
        return work;
    });
}

void CorrectedMicropolar::operator()(const Surroundings& around, StepReport& report, Read<field::role> role, Read<field::position> x,
                                     Read<field::velocity> u, Update<field::acceleration> a, Write<field::spin_change> change,
                                     Update<field::spin> w) {
    if (!torque_.is_zero()) torque_.each(around.step.time, x.values, [&](Index i, const Vec3& tau) { change[i] = tau; });
    const Read<field::spin> spin{w.values};
    report.work = with_kernel(around.step.kernel, viscous_support * around.step.support,
                              [&](const auto& W) { return advance(W, around, role, u, a, change, spin); });
    parallel_for(w.size(), [&](Index i) { w[i] += change[i]; });
}

void CarrySpin::operator()(const Surroundings& around, Write<field::spin_change> change, Update<field::spin> w) const {
    const ProjectionSystem& s = *system;
    with_kernel(around.step.kernel, viscous_support * around.step.support, [&](const auto& W) {
        parallel_for(w.size(), [&](Index i) {
            change[i].setZero();
            if (s.shift[i] != Vec3::Zero()) change[i] = carried(W, s.viscous, around.pairs, i, around.step.volume, w.data(), s.shift[i]);
        });
    });
    parallel_for(w.size(), [&](Index i) { w[i] += change[i]; });
}

}  // namespace whorl
