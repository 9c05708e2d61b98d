#include "engine/models/pressure/projection/corrected_micropolar.h"

#include <cmath>

#include "engine/core/parallel.h"
#include "engine/models/pressure/projection/sticking.h"

namespace whorl {
namespace {

Vec3 curl_of(const Mat3& G) { return {G(2, 1) - G(1, 2), G(0, 2) - G(2, 0), G(1, 0) - G(0, 1)}; }

}  // namespace

struct CorrectedMicropolar::Rates {
    Vec3 viscous, push, smoothing;        ///< rates of the velocity [m/s^2]
    Vec3 curl, diffused, spin_smoothing;  ///< curl u [1/s], gamma lap w/rho [m^2/s^2], rate of the spin [1/s^2]
    Vec3 velocity() const { return viscous + push + smoothing; }
};

/// Interaction forces on particle i for the velocities u and spins w.
/// @param whole kernel of the smoothing
template <class Kernel>
CorrectedMicropolar::Rates CorrectedMicropolar::rates(const Kernel& W, const Kernel& whole, const InteractionContext& context,
                                                      const Terms& terms, Index i, Span<const Vec3> u, Span<const Vec3> w,
                                                      Span<const Vec3> of_images) const {
    const ProjectionSystem& s = *system_;
    const StepContext& step = context.step;
    const Vec3 own_u = u[i], own_w = w[i];
    const bool mirrored = s.mirrors.count(i) > 0 && !s.near_surface[i];
    DifferenceSums of_u, of_w;
    if (mirrored && !(terms.smoothing_velocity > 0)) of_w = difference_sums<1>(W, context.pairs, i, step.volume, {w.data()}, whole)[0];
    else {
        const auto both = difference_sums<2>(W, context.pairs, i, step.volume, {u.data(), w.data()}, whole);
        of_u = both[0], of_w = both[1];
    }
    Mat3 G_u = of_u.gradient * s.viscous.correction[i];
    const Mat3 G_w = of_w.gradient * s.viscous.correction[i];
    Real trace = s.viscous.trace[i];
    Vec3 imbalance = s.viscous.imbalance[i];
    if (mirrored) {
        const MirroredSums sums = mirrored_sums(W, s, context, i, u, of_images, [](Index) { return Real(1); });
        of_u.laplacian = sums.laplacian, G_u = sums.gradient, trace = sums.trace, imbalance = sums.imbalance;
    }
    StickingSums walls{of_u.laplacian, trace, imbalance}, walls_w{of_w.laplacian, s.viscous.trace[i], s.viscous.imbalance[i]};
    const auto add_layers = [&](StickingSums& sums, Real diffusion, const auto& difference) {
        sums.add_layers(W, s, context, i, terms.of_layer, terms.slip, 1, difference, [&](Real moments, Real stiffness) {
            return step.dt * diffusion * s.laplacian_scale(step, i, moments, terms.over_lattice) * stiffness;
        });
    };
    add_layers(walls, terms.nu, [&](Index q) { return Vec3(own_u - surface_velocity(context, q)); });
    if (!options_.free_spin_walls)
        add_layers(walls_w, terms.g / static_cast<Real>(options_.micro_inertia),
                   [&](Index q) { return Vec3(own_w - context.solids.all[context.boundary.solid[q]].pose.angular_velocity); });
    const auto laplacian = [&](const StickingSums& sums, const Mat3& G) {
        const Real scale = s.laplacian_scale(step, i, sums.trace, terms.over_lattice);
        return Vec3(scale * (s.near_surface[i] ? sums.laplacian : Vec3(sums.laplacian - G * sums.imbalance)));
    };
    return {.viscous = terms.nu * laplacian(walls, G_u),
            .push = terms.kappa * curl_of(G_w),
            .smoothing = terms.smoothing_velocity * of_u.smooth,
            .curl = curl_of(G_u),
            .diffused = terms.g * laplacian(walls_w, G_w),
            .spin_smoothing = terms.smoothing_spin * of_w.smooth};
}

CorrectedMicropolar::Terms CorrectedMicropolar::terms(const InteractionContext& context) const {
    const MicropolarOptions& o = options_;
    const StepContext& step = context.step;
    const Real b = 1 / step.rest_density;
    return {.nu = static_cast<Real>(o.pair_viscosity) * b,
            .kappa = static_cast<Real>(o.coupling) * b,
            .g = static_cast<Real>(o.spin_viscosity) * b,
            .smoothing_velocity = o.part_a_step(o.smoothing_velocity, step.dt) / step.dt,
            .smoothing_spin = o.part_a_step(o.smoothing_spin, step.dt) / step.dt,
            .of_layer = system_->any_walls ? layer_factor(step.kernel, step.support, step.spacing) : 0,
            .over_lattice = 1 / lattice_gradient(step.kernel, one_sided_support * step.support, step.spacing),
            .slip = slips(context.solids)};
}

/// Largest rate of the viscosity, of the diffusion of the spin and of the exchange [1/s]
Real CorrectedMicropolar::fastest_rate(const Terms& t, Real spacing) const {
    const Real stiffness = 7 / (spacing * spacing), theta = static_cast<Real>(options_.micro_inertia);  // see SharpKernel
    return stiffness * (t.nu + t.g / theta) + t.kappa / theta * (1 + std::sqrt(1 + theta * stiffness));
}

/// (1 - exp(-z))/z: factor on the effect of a constant force over a step, if the value decays by exp(-z) in the step.
Real mean_decay(Real z) { return z > 0 ? -std::expm1(-z) / z : Real(1); }

template <class Kernel>
void CorrectedMicropolar::go_half(const Kernel& W, const Kernel& whole, const InteractionContext& context, const Terms& t,
                                  Read<field::role> role, Span<const Vec3> u, Span<const Vec3> torque, Span<const Vec3> w) {
    const Real half = context.step.dt / 2, over_theta = static_cast<Real>(1 / options_.micro_inertia);
    const Real ahead = options_.implicit_exchange ? mean_decay(2 * t.kappa * half * over_theta) : 1;
    middle_velocity_.resize(u.size()), middle_spin_.resize(u.size());
    const Span<const Vec3> of_images = image_velocities(*system_, context, u);
    parallel_for(u.size(), [&](Index i) {
        middle_velocity_[i] = u[i], middle_spin_[i] = w[i];
        if (role[i] != 0) return;
        const Rates r = rates(W, whole, context, t, i, u, w, of_images);
        const Vec3 exchanged = t.kappa * (r.curl - 2 * w[i]);
        middle_velocity_[i] += half * r.velocity();
        middle_spin_[i] += half * (ahead * over_theta * (exchanged + r.diffused + torque[i]) + r.spin_smoothing);
    });
}

template <class Kernel>
EnergyWork CorrectedMicropolar::advance(const Kernel& W, const Kernel& whole, const InteractionContext& context, const Terms& t,
                                        Read<field::role> role, Span<const Vec3> u, Update<field::acceleration> a,
                                        Write<field::spin_change> change, Span<const Vec3> w) const {
    const Real dt = context.step.dt, over_theta = static_cast<Real>(1 / options_.micro_inertia);
    const Real ahead = options_.implicit_exchange ? mean_decay(2 * t.kappa * dt * over_theta) : 1;
    const double energy = static_cast<double>(context.step.mass * dt), spin_energy = energy * static_cast<double>(ahead);
    const Span<const Vec3> of_images = image_velocities(*system_, context, middle_velocity_);
    return parallel_sum(a.size(), EnergyWork{}, [&](Index i) -> EnergyWork {
        if (role[i] != 0) {
            change[i].setZero();
            return {};
        }
        const Rates r = rates(W, whole, context, t, i, middle_velocity_, middle_spin_, of_images);
        const Vec3 tau = change[i], before = a[i];
        const Vec3 exchanged = t.kappa * (r.curl - 2 * (options_.implicit_exchange ? w[i] : middle_spin_[i]));
        a[i] += r.velocity();
        change[i] = dt * (ahead * over_theta * (exchanged + r.diffused + tau) + r.spin_smoothing);

        // Each force does work on the mean of the velocities before and after the kick, so the works add up to that of the kick.
        const Vec3 u_mid = u[i] + dt / 2 * a[i], w_mid = w[i] + change[i] / 2;
        EnergyWork work;
        work.gravity = energy * static_cast<double>(before.dot(u_mid));
        work.viscosity = energy * static_cast<double>(r.viscous.dot(u_mid)) + spin_energy * static_cast<double>(r.diffused.dot(w_mid));
        work.exchange = energy * static_cast<double>(r.push.dot(u_mid)) + spin_energy * static_cast<double>(exchanged.dot(w_mid));
        work.torque = spin_energy * static_cast<double>(tau.dot(w_mid));
        work.smoothing = energy * (static_cast<double>(r.smoothing.dot(u_mid)) +
                                   options_.micro_inertia * static_cast<double>(r.spin_smoothing.dot(w_mid)));
        return work;
    });
}

void CorrectedMicropolar::operator()(const InteractionContext& context, StepReport& report, Read<field::role> role, Read<field::position> x,
                                     Read<field::velocity> u, Update<field::acceleration> a, Write<field::spin_change> change,
                                     Update<field::spin> w) {
    const double middle = context.step.time + static_cast<double>(context.step.dt) / 2;
    parallel_for(change.size(), [&](Index i) { change[i].setZero(); });
    if (!torque_.is_zero()) torque_.each(middle, x.values, [&](Index i, const Vec3& tau) { change[i] = tau; });
    const StepContext& step = context.step;
    const Terms t = terms(context);
    with_kernel(step.kernel, step.support, [&]<class Kernel>(const Kernel& whole) {
        const Kernel W(one_sided_support * step.support, step.dimensions());
        constexpr Real calm = 1;  // the decay of no mode overshoots
        if (!options_.one_stage || step.dt * fastest_rate(t, step.spacing) > calm)
            go_half(W, whole, context, t, role, u.values, change.values, w.values);
        else middle_velocity_.assign(u.values.begin(), u.values.end()), middle_spin_.assign(w.values.begin(), w.values.end());
        Column<Vec3> before;
        if (context.solids.any_probed()) before.assign(a.values.begin(), a.values.end());
        report.work = advance(W, whole, context, t, role, u.values, a, change, w.values);
        if (before.empty()) return;
        const Remainder rest(context.solids, Push::viscous);
        const Real mu = static_cast<Real>(options_.pair_viscosity);
        write_sticking(
            W, *system_, context, role, middle_velocity_, [&](Index) { return mu; }, t.of_layer, t.over_lattice, t.slip);
        share_rest(rest, context, role, x.values, [&](Index i) { return Vec3(step.dt * (a[i] - before[i])); });
    });
    parallel_for(w.size(), [&](Index i) { w[i] += change[i]; });
}

}  // namespace whorl
