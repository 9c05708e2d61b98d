#include "engine/models/projection/corrected_viscosity.h"

#include <cmath>

#include "engine/core/parallel.h"

namespace whorl {

/// out_i = what viscosity does to fluid of velocity u.
template <class Kernel>
void CorrectedViscosity::accelerate(const Kernel& W, const Surroundings& around, Read<field::role> role, Read<field::viscosity> mu,
                                    Span<const Vec3> u, Span<Vec3> out) const {
    const ProjectionSystem& s = *system_;
    const StepContext& step = around.step;
    const Real V = step.volume, over_density = 1 / step.rest_density;
    const Real dimensions = static_cast<Real>(step.dimensions());
    const Real of_layer = s.any_walls ? layer_factor(step.kernel, step.support, step.spacing) : 0;
    const std::vector<char> slip = slips(around.solids);
    const Real over_lattice = 1 / lattice_gradient(step.kernel, viscous_support * step.support, step.spacing);
    parallel_for(u.size(), [&](Index i) {
        out[i].setZero();
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
            sum += own_mu * F * continued * (own - around.layer.velocity[q]);
            trace -= F * distance * distance;
            imbalance += F * to;
        });
        if (s.near_surface[i]) out[i] = 2 * over_lattice * over_density * sum;
        else out[i] = (2 * dimensions / std::max(trace, Real(0.1)) * over_density) * (sum - own_mu * (G * imbalance));
        if (friction_.acts()) out[i] -= own_mu * over_density * (friction_.coefficient(i) * own - friction_.load(i));
    });
}

void CorrectedViscosity::operator()(const Surroundings& around, Read<field::role> role, Read<field::viscosity> mu, Read<field::velocity> u,
                                    Update<field::acceleration> a) {
    const Index n = u.size();
    const Real half = around.step.dt / 2;
    change_.resize(n), middle_.resize(n);
    if (system_->any_walls) friction_.set(FrictionForm::central, around, system_->options.gate, 1);
    with_kernel(around.step.kernel, viscous_support * around.step.support, [&](const auto& W) {
        accelerate(W, around, role, mu, u.values, change_);
        parallel_for(n, [&](Index i) { middle_[i] = u[i] + half * change_[i]; });
        accelerate(W, around, role, mu, middle_, change_);
    });
    parallel_for(n, [&](Index i) { a[i] += change_[i]; });
}

}  // namespace whorl
