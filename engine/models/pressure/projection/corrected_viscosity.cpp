#include "engine/models/pressure/projection/corrected_viscosity.h"

#include <cmath>

#include "engine/core/parallel.h"
#include "engine/models/bodies/reaction.h"
#include "engine/models/pressure/projection/difference_sums.h"

namespace whorl {

struct CorrectedViscosity::Flow {
    const InteractionContext& context;
    Read<field::viscosity> mu;
    Span<const Vec3> u;
    Real of_layer, over_lattice;
    const std::vector<char>& slip;  ///< by solid
};

template <class Kernel>
void CorrectedViscosity::add_walls(const Kernel& W, const Flow& flow, Index i, StickingSums& sums) const {
    const StepContext& step = flow.context.step;
    const Real nu_dt = step.dt * flow.mu[i] / step.rest_density;
    sums.add_layers(
        W, *system_, flow.context, i, flow.of_layer, flow.slip, flow.mu[i],
        [&](Index q) { return Vec3(flow.u[i] - surface_velocity(flow.context, q)); },
        [&](Real trace, Real stiffness) { return nu_dt * system_->laplacian_scale(step, i, trace, flow.over_lattice) * stiffness; });
}

/// Viscous acceleration of particle i.
template <class Kernel>
Vec3 CorrectedViscosity::acceleration(const Kernel& W, const Flow& flow, Index i) const {
    const ProjectionSystem& s = *system_;
    const StepContext& step = flow.context.step;
    const Real over_density = 1 / step.rest_density;
    Vec3 sum = Vec3::Zero();
    Mat3 G = Mat3::Zero();
    const Vec3 own = flow.u[i];
    const Real own_mu = flow.mu[i];
    flow.context.pairs.groups_of(i, [&](const Pairs::Group& group) {
        Real other[3][Pairs::Group::most], viscosity[Pairs::Group::most];
        Real mixed[3] = {0, 0, 0}, S[9] = {0, 0, 0, 0, 0, 0, 0, 0, 0};
        group.gather(flow.u.data(), other);
        group.gather(flow.mu.data(), viscosity);
        for (Index l = 0; l < group.padded(); ++l) {
            const Real F = W.slope(group.distance[l]);
            const Real x = group.r[0][l], y = group.r[1][l], z = group.r[2][l];
            const Real mean = 2 * own_mu * viscosity[l] / std::max(own_mu + viscosity[l], min_positive);
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
    StickingSums sums{sum, s.viscous.trace[i], s.viscous.imbalance[i]};
    add_walls(W, flow, i, sums);
    const Real scale = s.laplacian_scale(step, i, sums.trace, flow.over_lattice) * over_density;
    Vec3 found = scale * (s.near_surface[i] ? sums.laplacian : Vec3(sums.laplacian - own_mu * (G * sums.imbalance)));
    if (friction_.acts()) found -= own_mu * over_density * (friction_.coefficient(i) * own - friction_.load(i));
    return found;
}

/// The same for a particle near flat walls along which the fluid slips freely.
template <class Kernel>
Vec3 CorrectedViscosity::beside_mirrors(const Kernel& W, const Flow& flow, Index i, Span<const Vec3> of_images) const {
    const StepContext& step = flow.context.step;
    const Vec3 own = flow.u[i];
    const Real own_mu = flow.mu[i];
    const auto mean = [&](Index j) { return 2 * own_mu * flow.mu[j] / std::max(own_mu + flow.mu[j], min_positive); };
    const MirroredSums sums = mirrored_sums(W, *system_, flow.context, i, flow.u, of_images, mean);
    StickingSums walls{sums.laplacian, sums.trace, sums.imbalance};
    add_walls(W, flow, i, walls);
    const Real scale = system_->laplacian_scale(step, i, walls.trace, flow.over_lattice) / step.rest_density;
    Vec3 found = scale * (walls.laplacian - own_mu * (sums.gradient * walls.imbalance));
    if (friction_.acts()) found -= own_mu / step.rest_density * (friction_.coefficient(i) * own - friction_.load(i));
    return found;
}

void CorrectedViscosity::operator()(const InteractionContext& context, Read<field::role> role, Read<field::viscosity> mu,
                                    Read<field::velocity> u, Update<field::acceleration> a) {
    const ProjectionSystem& s = *system_;
    const StepContext& step = context.step;
    const Index n = u.size();
    const std::vector<char> slip = slips(context.solids);
    middle_.resize(n);
    if (s.any_walls) friction_.set(FrictionForm::central, context, s.options.gate, 1);
    Flow flow{context,
              mu,
              u.values,
              s.any_walls ? layer_factor(step.kernel, step.support, step.spacing) : 0,
              1 / lattice_gradient(step.kernel, one_sided_support * step.support, step.spacing),
              slip};
    with_viscous_kernels(step, [&](const auto& sharp, const auto& narrow) {
        Span<const Vec3> of_images = image_velocities(s, context, flow.u);
        const auto of = [&](Index i) {
            if (s.inside[i]) return acceleration(sharp, flow, i);
            if (s.mirrors.count(i) > 0 && !s.near_surface[i]) return beside_mirrors(narrow, flow, i, of_images);
            return acceleration(narrow, flow, i);
        };
        parallel_for(n, [&](Index i) { middle_[i] = role[i] == 0 ? Vec3(u[i] + step.dt / 2 * of(i)) : u[i]; });
        flow.u = middle_;
        of_images = image_velocities(s, context, flow.u);
        Column<Vec3> before;
        if (context.solids.any_probed()) before.assign(a.values.begin(), a.values.end());
        parallel_for(n, [&](Index i) {
            if (role[i] == 0) a[i] += of(i);
        });
        if (!context.solids.any_ledger()) return;
        const Remainder rest(context.solids, Push::viscous);
        write_sticking(
            narrow, s, context, role, flow.u, [&](Index i) { return mu[i]; }, flow.of_layer, flow.over_lattice, slip);
        friction_.write_ledgers(context, role, flow.u, [&](Index i) { return mu[i] / step.rest_density; });
        share_rest(rest, context, role, context.pairs.x_own, [&](Index i) { return Vec3(step.dt * (a[i] - before[i])); });
    });
}

}  // namespace whorl
