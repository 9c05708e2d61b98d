#include "engine/models/projection/corrected_viscosity.h"

#include <cmath>

#include "engine/core/parallel.h"
#include "engine/models/bodies/reaction.h"

namespace whorl {

struct CorrectedViscosity::Flow {
    const Surroundings& around;
    Read<field::viscosity> mu;
    Span<const Vec3> u;
    Real of_layer, over_lattice;
    const std::vector<char>& slip;  ///< of each solid
};

/// What viscosity does to particle i.
template <class Kernel>
Vec3 CorrectedViscosity::acceleration(const Kernel& W, const Flow& flow, Index i) const {
    const ProjectionSystem& s = *system_;
    const StepContext& step = flow.around.step;
    const Real over_density = 1 / step.rest_density, dimensions = static_cast<Real>(step.dimensions());
    Vec3 sum = Vec3::Zero();
    Mat3 G = Mat3::Zero();
    const Vec3 own = flow.u[i];
    const Real own_mu = flow.mu[i];
    flow.around.pairs.groups_of(i, [&](const Pairs::Group& group) {
        Real other[3][Pairs::Group::most], viscosity[Pairs::Group::most];
        Real mixed[3] = {0, 0, 0}, S[9] = {0, 0, 0, 0, 0, 0, 0, 0, 0};
        group.gather(flow.u.data(), other);
        group.gather(flow.mu.data(), viscosity);
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
    sum *= step.volume;
    G = step.volume * G * s.viscous.correction[i];
    Real trace = s.viscous.trace[i];
    Vec3 imbalance = s.viscous.imbalance[i];
    each_sticking_layer(W, s, flow.around, i, flow.of_layer, flow.slip,
                        [&](Index q, Real F, Real continued, const Vec3& to, Real distance) {
                            sum += own_mu * F * continued * (own - surface_velocity(flow.around, q));
                            trace -= F * distance * distance;
                            imbalance += F * to;
                        });
    Vec3 found = s.near_surface[i] ? Vec3(2 * flow.over_lattice * over_density * sum)
                                   : Vec3((2 * dimensions / std::max(trace, Real(0.1)) * over_density) * (sum - own_mu * (G * imbalance)));
    if (friction_.acts()) found -= own_mu * over_density * (friction_.coefficient(i) * own - friction_.load(i));
    return found;
}

void CorrectedViscosity::operator()(const Surroundings& around, Read<field::role> role, Read<field::viscosity> mu, Read<field::velocity> u,
                                    Update<field::acceleration> a) {
    const ProjectionSystem& s = *system_;
    const StepContext& step = around.step;
    const Index n = u.size();
    const std::vector<char> slip = slips(around.solids);
    middle_.resize(n);
    if (s.any_walls) friction_.set(FrictionForm::central, around, s.options.gate, 1);
    Flow flow{around,
              mu,
              u.values,
              s.any_walls ? layer_factor(step.kernel, step.support, step.spacing) : 0,
              1 / lattice_gradient(step.kernel, one_sided_support * step.support, step.spacing),
              slip};
    with_viscous_kernels(step, [&](const auto& sharp, const auto& narrow) {
        const auto of = [&](Index i) { return s.inside[i] ? acceleration(sharp, flow, i) : acceleration(narrow, flow, i); };
        parallel_for(n, [&](Index i) { middle_[i] = role[i] == 0 ? Vec3(u[i] + step.dt / 2 * of(i)) : u[i]; });
        flow.u = middle_;
        parallel_for(n, [&](Index i) {
            if (role[i] == 0) a[i] += of(i);
        });
        if (around.solids.any_free()) push_bodies(narrow, flow, role);
    });
}

/// The stress on a rigid surface is mu d/dn of the velocity over that of the body's own motion, continued into the fluid.
template <class Kernel>
void CorrectedViscosity::push_bodies(const Kernel& W, const Flow& flow, Read<field::role> role) const {
    const ProjectionSystem& s = *system_;
    const Surroundings& around = flow.around;
    const StepContext& step = around.step;
    const SolidParticles& layer = around.layer;
    const Real half = step.spacing / 2;
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
            const Vec3 relative = flow.u[i] - (body.velocity + turning.cross(arm.template cast<double>())).template cast<Real>();
            each_sticking_layer(
                W, s, around, i, flow.of_layer, flow.slip, [&](Index q, Real F, Real continued, const Vec3&, Real distance) {
                    trace -= F * distance * distance;
                    if (static_cast<std::size_t>(layer.solid[q]) != k) return;
                    const Vec3d force = (-F * continued * relative).template cast<double>();
                    one += Wrench{force, ((layer.position[q] + half * layer.normal[q]).template cast<double>() - body.centre).cross(force)};
                });
            const Real weight =
                s.near_surface[i] ? 2 * flow.over_lattice : 2 * static_cast<Real>(step.dimensions()) / std::max(trace, Real(0.1));
            const double scale = static_cast<double>(weight * flow.mu[i] * step.volume);
            return Wrench{scale * one.force, scale * one.torque};
        });
        body.force += sum.force;
        body.torque += sum.torque;
    }
}

}  // namespace whorl
