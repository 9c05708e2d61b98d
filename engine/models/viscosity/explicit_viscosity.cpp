#include "engine/models/viscosity/explicit_viscosity.h"

#include <cmath>

#include "engine/core/parallel.h"
#include "engine/models/bodies/reaction.h"
#include "engine/models/boundary/friction.h"

namespace whorl {

namespace {

/// Smooths u by the fraction alpha. @param change written: the change of u
void smooth(const InteractionContext& context, Real alpha, bool printed, Read<field::role> role, Read<field::density> rho,
            Span<Vec3> change, Span<Vec3> u) {
    const FluidPairs& pairs = context.pairs;
    const StepContext& step = context.step;
    const Real densities = printed ? 1 : 2;  // number of densities in the mean of the pair
    with_kernel(step.kernel, step.support, [&](const auto& kernel) {
        parallel_for(static_cast<Index>(u.size()), [&](Index i) {
            Vec3 sum = Vec3::Zero();
            const Vec3 own = u[i];
            const Real own_density = printed ? 0 : rho[i];
            pairs.groups_of(i, [&](const Pairs::Group& group) {
                alignas(64) Real v[3][Pairs::Group::most], density[Pairs::Group::most];
                group.gather(u.data(), v), group.gather(rho.data(), density);
                Real x = 0, y = 0, z = 0;
                for (Index l = 0; l < group.padded(); ++l) {
                    const Real share = kernel.value(group.distance[l]) / (own_density + density[l]);
                    x += share * (v[0][l] - own[0]), y += share * (v[1][l] - own[1]), z += share * (v[2][l] - own[2]);
                }
                sum += Vec3(x, y, z);
            });
            change[i] = role[i] == 0 ? Vec3(alpha * densities * step.mass * sum) : Vec3::Zero();
        });
    });
    parallel_for(static_cast<Index>(u.size()), [&](Index i) { u[i] += change[i]; });
}

}  // namespace

void XsphViscosity::operator()(const InteractionContext& context, Read<field::role> role, Read<field::density> rho,
                               Write<field::smoothing> change, Update<field::velocity> u) const {
    smooth(context, alpha, printed, role, rho, change.values, u.values);
}

void XsphSpin::operator()(const InteractionContext& context, StepReport& report, Read<field::role> role, Read<field::density> rho,
                          Write<field::smoothing> change, Update<field::spin> w) const {
    smooth(context, beta, true, role, rho, change.values, w.values);
    if (!report.work) return;
    report.work->smoothing += micro_inertia * static_cast<double>(context.step.mass) *
                              parallel_sum(w.size(), [&](Index i) { return static_cast<double>(change[i].dot(w[i] - change[i] / 2)); });
}

namespace {

/// Share of a pair in mu Lap u, without V_j mu_ij. u_ij = u_i - u_j, slope = W'(r)/r <= 0. Acts either along u_ij or along r_ij.
struct Brookshaw {
    static constexpr bool along_r = false;
    Real lattice;  ///< 1/lattice_gradient(), the factor by which every flow would otherwise be too viscous
    Real operator()(Real, Real, Real slope) const { return 2 * lattice * slope; }
};
struct Monaghan {
    static constexpr bool along_r = true;
    Real factor;     ///< 2 (D + 2) along_pairs_factor()
    Real softening;  ///< 0.01 h^2
    Monaghan(KernelForm kernel, Real support, Real spacing)
        : factor(2 * static_cast<Real>(kernel.dimensions + 2) * along_pairs_factor(kernel, support, spacing)),
          softening(Real(0.01) * support * support / 4) {}
    Monaghan(KernelForm kernel, Real support)
        : factor(2 * static_cast<Real>(kernel.dimensions + 2)), softening(Real(0.01) * support * support / 4) {}
    Real operator()(Real approach, Real r, Real slope) const { return factor * approach / (r * r + softening) * slope; }
};

template <class Kernel, class Form>
void add_viscosity(const Kernel& kernel, const Form& form, const ViscosityOptions& options, const InteractionContext& context,
                   Read<field::role> role, Read<field::density> rho, Read<field::viscosity> mu, Read<field::velocity> u,
                   Update<field::acceleration> a) {
    const BoundaryParticles& boundary = context.boundary;
    const StepContext& step = context.step;
    const std::vector<char> slip = slips(context.solids);
    WallFriction friction;
    friction.set(options.without_spin() == LaplacianForm::monaghan ? FrictionForm::along : FrictionForm::central, context, options.gate,
                 options.solid_factor);
    const WallShear shear{step.spacing / 2};
    // Share of a solid in rho_i a_i, without the factor weight(i) of all solids.
    const auto by_solid = [&](Index i, Index s, const Vec3& r, Real distance) {
        const auto whose = static_cast<std::size_t>(boundary.solid[s]);
        if (slip[whose]) return Vec3(Vec3::Zero());
        const Real stretch = shear.stretch(r, boundary.normal[s]);
        // The wall's rigid motion relative to its motion at i, plus the shear continued behind the surface.
        const Vec3 wall = context.solids.all[whose].pose.velocity_at(boundary.position[s] + r);
        const Vec3 u_is = stretch * (u[i] - wall) + (wall - boundary.velocity[s]);
        return Vec3(boundary.volume[s] * mu[i] * form(u_is.dot(r), distance, kernel.slope(distance)) * (Form::along_r ? r : u_is));
    };
    const auto weight = [&](Index i) {
        return boundary.size() > 0
                   ? options.solid_factor * options.gate.weight(kernel, i, context.solid_pairs, boundary.volume, options.solid_factor)
                   : Real(0);
    };
    parallel_for(a.size(), [&](Index i) {
        Vec3 sum = Vec3::Zero();
        const Vec3 own = u[i];
        const Real own_mu = mu[i];
        context.pairs.groups_of(i, [&](const Pairs::Group& group) {
            Real density[Pairs::Group::most], other_mu[Pairs::Group::most], other[3][Pairs::Group::most], part[3] = {0, 0, 0};
            group.gather(rho.data(), density), group.gather(mu.data(), other_mu), group.gather(u.data(), other);
            for (Index l = 0; l < group.padded(); ++l) {
                const Real both = own_mu + other_mu[l], mean = both > 0 ? 2 * own_mu * other_mu[l] / both : 0;
                const Real x = group.r[0][l], y = group.r[1][l], z = group.r[2][l], r = group.distance[l];
                const Real ux = own[0] - other[0][l], uy = own[1] - other[1][l], uz = own[2] - other[2][l];
                const Real share = step.mass / density[l] * mean * form(ux * x + uy * y + uz * z, r, kernel.slope(r));
                part[0] += share * (Form::along_r ? x : ux), part[1] += share * (Form::along_r ? y : uy),
                    part[2] += share * (Form::along_r ? z : uz);
            }
            sum += Vec3(part[0], part[1], part[2]);
        });
        if (const Real solid_factor = weight(i); solid_factor > 0) {
            context.solid_pairs.of(i, [&](Index s, const Vec3& r, Real distance) { sum += solid_factor * by_solid(i, s, r, distance); });
            // The wall's area does not depend on the kernel sums at the wall. So the acceleration is mu/rho_0 (not mu/rho) times this term.
            if (friction.acts()) sum -= rho[i] / step.rest_density * own_mu * (friction.coefficient(i) * own - friction.load(i));
        }
        a[i] += sum / rho[i];
    });
    react(context, Push::viscous, role, step.mass * step.dt, [&](Index i) {
        return
            [&, i, of_i = weight(i) / rho[i]](Index s, const Vec3& r, Real distance) { return Vec3(of_i * by_solid(i, s, r, distance)); };
    });
    friction.write_ledgers(context, role, u.values, [&](Index i) { return mu[i] / step.rest_density; });
}

}  // namespace

void ExplicitViscosity::operator()(const InteractionContext& context, Read<field::role> role, Read<field::density> rho,
                                   Read<field::viscosity> mu, Read<field::velocity> u, Update<field::acceleration> a) const {
    const StepContext& step = context.step;
    with_kernel(step.kernel, step.support, [&](const auto& kernel) {
        const auto add = [&](const auto& form) { add_viscosity(kernel, form, options, context, role, rho, mu, u, a); };
        const bool monaghan = options.without_spin() == LaplacianForm::monaghan;
        if (monaghan && options.printed) add(Monaghan(step.kernel, step.support));
        else if (monaghan) add(Monaghan(step.kernel, step.support, step.spacing));
        else add(Brookshaw{options.printed ? Real(1) : 1 / lattice_gradient(step.kernel, step.support, step.spacing)});
    });
}

// Stiffness of a lattice with central forces, C_abcd = sum V w r_a r_b r_c r_d/2: C_xxxx and C_xxyy = C_xyxy. The exact values are 3 mu and
// mu, so that stretching at constant volume, (C_xxxx - C_xxyy)/2, and shear, C_xyxy, are both mu. The same holds in 2D.
LatticeStiffness monaghan_lattice_stiffness(KernelForm of, double support, double spacing) {
    return with_kernel(of, static_cast<Real>(support), [&](const auto& kernel) {
        const Monaghan form(of, static_cast<Real>(support), static_cast<Real>(spacing));
        const int reach = static_cast<int>(std::ceil(support / spacing));
        const double share = std::pow(spacing, 4 + of.dimensions);
        double along = 0, across = 0;
        each_lattice_point(of.dimensions, reach, [&](int x, int y, int z) {
            if (x == 0 && y == 0 && z == 0) return;
            const auto r = static_cast<Real>(spacing * std::sqrt(x * x + y * y + z * z));
            const double w = -form(1, r, kernel.slope(r)) / 2 * share;
            along += w * x * x * x * x;
            across += w * x * x * y * y;
        });
        return LatticeStiffness{(along - across) / 2, across};
    });
}

double viscous_step(double support, double kinematic_viscosity) { return 0.125 * support * support / (4 * kinematic_viscosity); }

}  // namespace whorl
