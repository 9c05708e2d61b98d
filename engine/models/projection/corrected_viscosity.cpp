#include "engine/models/projection/corrected_viscosity.h"

#include <cmath>

#include "engine/core/parallel.h"
#include "engine/models/bodies/reaction.h"

namespace whorl {

void CorrectedViscosity::operator()(const Surroundings& around, Read<field::role> role, Read<field::viscosity> mu, Read<field::velocity> u,
                                    Update<field::acceleration> a) {
    const ProjectionSystem& s = *system_;
    const StepContext& step = around.step;
    const Real V = step.volume, over_density = 1 / step.rest_density;
    const Real dimensions = static_cast<Real>(step.dimensions());
    const Real of_layer = s.any_walls ? layer_factor(step.kernel, step.support, step.spacing) : 0;
    const std::vector<char> slip = slips(around.solids);
    if (s.any_walls) friction_.set(FrictionForm::central, around, s.options.gate, 1);
    const Real support = viscous_support * step.support, over_lattice = 1 / lattice_gradient(step.kernel, support, step.spacing);
    with_kernel(step.kernel, support, [&](const auto& W) {
        parallel_for(u.size(), [&](Index i) {
            if (role[i] != 0) return;
            Vec3 sum = Vec3::Zero();
            Mat3 G = Mat3::Zero();
            const Vec3 own = u[i];
            const Real own_mu = mu[i];
            around.pairs.groups_of(i, [&](const Pairs::Group& group) {
                Real other[3][Pairs::Group::most], viscosity[Pairs::Group::most];
                Real mixed[3] = {0, 0, 0}, S[9] = {0, 0, 0, 0, 0, 0, 0, 0, 0};
                group.gather(u.data(), other);
                group.gather(mu.data(), viscosity);
                for (Index l = 0; l < group.padded(); ++l) {
                    const Real F = W.slope(group.distance[l]);
                    const Real x = group.r[0][l], y = group.r[1][l], z = group.r[2][l];
                    const Real mean = 2 * own_mu * viscosity[l] / std::max(own_mu + viscosity[l], smallest);
                    const Real p = F * (own[0] - other[0][l]), q = F * (own[1] - other[1][l]), t = F * (own[2] - other[2][l]);
                    mixed[0] += mean * p, mixed[1] += mean * q, mixed[2] += mean * t;
                    S[0] -= p * x, S[1] -= p * y, S[2] -= p * z;
                    S[3] -= q * x, S[4] -= q * y, S[5] -= q * z;
                    S[6] -= t * x, S[7] -= t * y, S[8] -= t * z;
                }
                sum += Vec3(mixed[0], mixed[1], mixed[2]);
                for (int k = 0; k < 9; ++k) G(k / 3, k % 3) += S[k];
            });
            sum *= V;
            G = V * G * s.viscous.correction[i];
            Real trace = s.viscous.trace[i];
            Vec3 imbalance = s.viscous.imbalance[i];
            each_sticking_layer(W, s, around, i, of_layer, slip, [&](Index q, Real F, Real continued, const Vec3& to, Real distance) {
                sum += own_mu * F * continued * (own - surface_velocity(around, q));
                trace -= F * distance * distance;
                imbalance += F * to;
            });
            if (s.near_surface[i]) a[i] += 2 * over_lattice * over_density * sum;
            else a[i] += (2 * dimensions / std::max(trace, Real(0.1)) * over_density) * (sum - own_mu * (G * imbalance));
            if (friction_.acts()) a[i] -= own_mu * over_density * (friction_.coefficient(i) * own - friction_.load(i));
        });
        if (around.solids.any_free()) push_bodies(W, around, role, mu, u);
    });
}

/// The stress on a rigid surface is mu d/dn of the velocity over that of the body's own motion, continued into the fluid.
template <class Kernel>
void CorrectedViscosity::push_bodies(const Kernel& W, const Surroundings& around, Read<field::role> role, Read<field::viscosity> mu,
                                     Read<field::velocity> u) const {
    const ProjectionSystem& s = *system_;
    const StepContext& step = around.step;
    const SolidParticles& layer = around.layer;
    const Real of_layer = layer_factor(step.kernel, step.support, step.spacing), half = step.spacing / 2;
    const Real at_surface = 2 / lattice_gradient(step.kernel, viscous_support * step.support, step.spacing);
    const std::vector<char> slip = slips(around.solids);
    const std::vector<Index> near = particles_at_bodies(around);
    for (std::size_t k = 0; k < around.solids.all.size(); ++k) {
        if (!around.solids.all[k].body) continue;
        RigidBody& body = *around.solids.all[k].body;
        const Vec3d turning = body.angular_velocity();
        const Wrench sum = parallel_sum(static_cast<Index>(near.size()), Wrench{}, [&](Index e) {
            Wrench one;
            const Index i = near[e];
            if (role[i] != 0) return one;
            Real trace = s.viscous.trace[i];
            const Vec3 arm = step.domain.minimum_image(around.pairs.x_own[i] - body.centre.template cast<Real>());
            const Vec3 relative = u[i] - (body.velocity + turning.cross(arm.template cast<double>())).template cast<Real>();
            each_sticking_layer(W, s, around, i, of_layer, slip, [&](Index q, Real F, Real continued, const Vec3&, Real distance) {
                trace -= F * distance * distance;
                if (static_cast<std::size_t>(layer.solid[q]) != k) return;
                const Vec3d force = (-F * continued * relative).template cast<double>();
                one += Wrench{force, ((layer.position[q] + half * layer.normal[q]).template cast<double>() - body.centre).cross(force)};
            });
            const Real weight = s.near_surface[i] ? at_surface : 2 * static_cast<Real>(step.dimensions()) / std::max(trace, Real(0.1));
            const double scale = static_cast<double>(weight * mu[i] * step.volume);
            return Wrench{scale * one.force, scale * one.torque};
        });
        body.force += sum.force;
        body.torque += sum.torque;
    }
}

}  // namespace whorl
