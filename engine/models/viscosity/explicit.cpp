#include "engine/models/viscosity/explicit.h"

#include <limits>

#include "engine/core/parallel.h"
#include "engine/models/boundary/friction.h"

namespace whorl {

void XsphViscosity::operator()(const FluidPairs& pairs, const StepContext& step, Read<field::role> role, Read<field::density> rho,
                               Write<field::smoothing> change, Update<field::velocity> u) const {
    with_kernel(step.kernel, step.support, [&](const auto& kernel) {
        parallel_for(u.size(), [&](Index i) {
            Vec3 sum = Vec3::Zero();
            const Vec3 own = u[i];
            pairs.of(i, [&](Index j, const Vec3&, Real r) { sum += kernel.value(r) / (rho[i] + rho[j]) * (u[j] - own); });
            change[i] = role[i] == 0 ? Vec3(alpha * 2 * step.mass * sum) : Vec3::Zero();
        });
    });
    parallel_for(u.size(), [&](Index i) { u[i] += change[i]; });
}

namespace {

/// The pair's share of mu Lap u but for V_j mu_ij: u_ij = u_i - u_j, slope = W'(r)/r <= 0.
struct Brookshaw {
    Real lattice;  ///< 3 over the lattice sum of V |W'| r, 3.06 with R = 2 d: without it every flow is that much too viscous
    Vec3 operator()(const Vec3& u_ij, const Vec3&, Real, Real slope) const { return 2 * lattice * slope * u_ij; }
};
struct Monaghan {
    Real factor;     ///< along_pairs_factor()
    Real softening;  ///< 0.01 h^2
    Vec3 operator()(const Vec3& u_ij, const Vec3& r_ij, Real r, Real slope) const {
        return 10 * factor * u_ij.dot(r_ij) / (r * r + softening) * slope * r_ij;
    }
};

template <class Kernel, class Form>
void add_viscosity(const Kernel& kernel, const Form& form, const ExplicitOptions& options, const FluidPairs& pairs, const SolidPairs& solid_pairs, const Solids& solids,
                   const SolidParticles& layer, const StepContext& step, Read<field::density> rho, Read<field::viscosity> mu,
                   Read<field::velocity> u, Update<field::acceleration> a) {
    const std::vector<char> slip = slips(solids);
    WallFriction friction;
    friction.set(options.monaghan ? FrictionForm::along : FrictionForm::central, solid_pairs, solids, layer, step);
    const WallShear shear{step.spacing / 2};
    const auto slope_at = [&](Real r) { return kernel.derivative(r) / std::max(r, std::numeric_limits<Real>::min()); };
    parallel_for(a.size(), [&](Index i) {
        Vec3 sum = Vec3::Zero();
        const Vec3 own = u[i];
        const Real own_mu = mu[i];
        pairs.of(i, [&](Index j, const Vec3& r, Real distance) {
            const Real both = own_mu + mu[j];
            const Real mean = both > 0 ? 2 * own_mu * mu[j] / both : 0;
            sum += step.mass / rho[j] * mean * form(own - u[j], r, distance, slope_at(distance));
        });
        const Real gate = layer.size() > 0 ? options.gate.weight(kernel, i, solid_pairs, layer.volume, options.solid_factor) : 0;
        const Real solid_factor = gate * options.solid_factor;
        if (solid_factor > 0)
            solid_pairs.of(i, [&](Index s, const Vec3& r, Real distance) {
                const auto k = static_cast<std::size_t>(s);
                const auto whose = static_cast<std::size_t>(layer.solid[k]);
                if (slip[whose]) return;
                const Real stretch = shear.stretch(r, layer.normal[k]);
                // The wall's rigid motion, seen from i, plus the shear continued behind the surface.
                const Vec3 wall = solids.all[whose].pose.velocity_at(layer.position[k] + r);
                const Vec3 u_is = stretch * (own - wall) + (wall - layer.velocity[k]);
                sum += solid_factor * layer.volume[k] * own_mu * form(u_is, r, distance, slope_at(distance));
            });
        // The wall's area does not depend on the density that the kernel finds beside it: the acceleration is mu/rho_0 times that.
        if (friction.acts() && solid_factor > 0) sum -= gate * rho[i] / step.rest_density * own_mu * (friction.hold(i) * own - friction.pull(i));
        a[i] += sum / rho[i];
    });
}

}  // namespace

void ExplicitViscosity::operator()(const FluidPairs& pairs, const SolidPairs& solid_pairs, const Solids& solids, const SolidParticles& layer,
                                   const StepContext& step, Read<field::density> rho, Read<field::viscosity> mu, Read<field::velocity> u,
                                   Update<field::acceleration> a) const {
    with_kernel(step.kernel, step.support, [&](const auto& kernel) {
        const auto add = [&](const auto& form) {
            add_viscosity(kernel, form, options, pairs, solid_pairs, solids, layer, step, rho, mu, u, a);
        };
        if (options.monaghan) add(Monaghan{along_pairs_factor(step.kernel, step.support, step.spacing), Real(0.01) * step.support * step.support / 4});
        else add(Brookshaw{Real(3) / lattice_second_moment(step.kernel, step.support, step.spacing)});
    });
}

double viscous_step(double support, double kinematic_viscosity) { return 0.125 * support * support / (4 * kinematic_viscosity); }

}  // namespace whorl
