#include "engine/models/viscosity/pairwise.h"

#include <cmath>
#include <limits>

#include "engine/core/parallel.h"
#include "engine/models/boundary/wall.h"

namespace whorl {
namespace {

/// 2 (d + 2) f |W'(r)|/r / (r^2 + 0.01 h^2)
template <class Kernel>
Real pair_stiffness(const Kernel& kernel, Real factor, Real support, Real distance) {
    const Real softening = Real(0.01) * support * support / 4;
    return -10 * factor * kernel.derivative(distance) / std::max(distance, std::numeric_limits<Real>::min()) /
           (distance * distance + softening);
}

}  // namespace

void PairwiseOperator::set_up(const FluidPairs& pairs, const SolidPairs& solid_pairs, const Solids& solids, const SolidParticles& layer,
                              const StepContext& step, Read<field::role> role, Read<field::viscosity> mu) {
    const std::size_t n = static_cast<std::size_t>(mu.size());
    pairs_ = &pairs;
    pair_.resize(pairs.other.size());
    free_.resize(n);
    wall_.clear(), wall_force_.clear();
    const bool walls = layer.size() > 0;
    if (walls) wall_.resize(n), wall_force_.resize(n);
    const std::vector<char> slip = slips(solids);
    friction_.set(FrictionForm::along, solid_pairs, solids, layer, step);
    const WallShear shear{step.spacing / 2};
    const Real factor = along_pairs_factor(step.kernel, step.support, step.spacing),
               column = layer_factor(step.kernel, step.support, step.spacing);
    Column<Mat3> blocks(n);
    std::vector<char> touches(n, 0);
    with_kernel(step.kernel, step.support, [&](const auto& kernel) {
        parallel_for(mu.size(), [&](Index i) {
            free_[i] = role[i] == 0;
            const Real own_mu = mu[i], scale = step.dt / step.rest_density;
            Mat3 B = Mat3::Identity();
            std::size_t k = pairs.first[i];
            pairs.of(i, [&](Index j, const Vec3& r, Real distance) {
                const Real both = own_mu + mu[j], mean = both > 0 ? 2 * own_mu * mu[j] / both : 0;
                pair_[k] = std::sqrt(scale * step.volume * mean * pair_stiffness(kernel, factor, step.support, distance)) * r;
                B += pair_[k] * pair_[k].transpose();
                ++k;
            });
            if (walls) {
                Mat3 hold = Mat3::Zero();
                Vec3 drag = Vec3::Zero();
                solid_pairs.of(i, [&](Index s, const Vec3& r, Real) {
                    const std::size_t whose = static_cast<std::size_t>(layer.solid[s]);
                    if (slip[whose]) return;
                    touches[i] = 1;
                    const Vec3 here = solids.all[whose].pose.velocity_at(layer.position[s] + r);
                    const Real weight = scale * column * layer.volume[s] * own_mu;
                    each_layer(r, layer.normal[s], step.spacing, step.support, [&](const Vec3& to, Real distance, Real below) {
                        // stretch (u_i - u_wall(x_i)) + (u_wall(x_i) - u_wall(x_l)), with the rigid motion of the solid u_wall: the last is
                        // across r_l
                        const Mat3 c = weight * shear.stretch(r, layer.normal[s], below) *
                                       pair_stiffness(kernel, factor, step.support, distance) * to * to.transpose();
                        hold += c;
                        drag -= c * here;
                    });
                });
                if (friction_.acts()) {
                    hold += scale * own_mu * friction_.hold(i);
                    drag -= scale * own_mu * friction_.pull(i);
                }
                wall_[i] = hold;
                wall_force_[i] = drag;
                B += hold;
            }
            blocks[i] = B;
        });
    });
    touches_wall_ = friction_.acts() || parallel_sum(size(), [&](Index i) { return touches[i]; }) > 0;
    diagonal_.set(std::move(blocks), free_);
}

void PairwiseOperator::multiply(Span<const Vec3> u, Span<Vec3> y) const {
    parallel_for(size(), [&](Index i) {
        if (!free_[i]) {
            y[i].setZero();
            return;
        }
        const Vec3 own = u[i];
        Vec3 sum = own;
        for (std::size_t k = pairs_->first[i]; k < pairs_->first[i + 1]; ++k) {
            const std::size_t j = static_cast<std::size_t>(pairs_->other[k]);
            sum += (free_[j] ? Vec3(own - u[j]) : own).dot(pair_[k]) * pair_[k];
        }
        if (!wall_.empty()) sum += wall_[i] * own;
        y[i] = sum;
    });
}

void PairwiseOperator::force(Span<const Vec3> u, Span<Vec3> y) const {
    parallel_for(size(), [&](Index i) {
        const Vec3 own = u[i];
        Vec3 sum = own;
        for (std::size_t k = pairs_->first[i]; k < pairs_->first[i + 1]; ++k) sum += (own - u[pairs_->other[k]]).dot(pair_[k]) * pair_[k];
        if (!wall_.empty()) sum += wall_[i] * own + wall_force_[i];
        y[i] = sum;
    });
}

LatticeStiffness pairwise_lattice_stiffness(KernelKind kind, double support, double spacing) {
    // Stiffness of a lattice with central forces, C_abcd = sum V w r_a r_b r_c r_d/2: C_xxxx and C_xxyy = C_xyxy. Exact: 3 mu and mu, so
    // that stretching at constant volume, (C_xxxx - C_xxyy)/2, and shear, C_xyxy, both are mu.
    return with_kernel(kind, static_cast<Real>(support), [&](const auto& kernel) {
        const int reach = static_cast<int>(std::ceil(support / spacing));
        const Real factor = along_pairs_factor(kind, static_cast<Real>(support), static_cast<Real>(spacing));
        double along = 0, across = 0;
        for (int x = -reach; x <= reach; ++x)
            for (int y = -reach; y <= reach; ++y)
                for (int z = -reach; z <= reach; ++z) {
                    if (x == 0 && y == 0 && z == 0) continue;
                    const double r2 = spacing * spacing * (x * x + y * y + z * z);
                    const double w = pair_stiffness(kernel, factor, static_cast<Real>(support), static_cast<Real>(std::sqrt(r2))) / 2;
                    along += w * std::pow(spacing, 7) * x * x * x * x;
                    across += w * std::pow(spacing, 7) * x * x * y * y;
                }
        return LatticeStiffness{(along - across) / 2, across};
    });
}

void PairwiseViscosity::operator()(const FluidPairs& pairs, const SolidPairs& solid_pairs, const Solids& solids,
                                   const SolidParticles& layer, const StepContext& step, StepReport& report, Read<field::role> role,
                                   Read<field::position> x, Read<field::viscosity> mu, Update<field::velocity> u,
                                   Update<field::viscous_acceleration> last) {
    operator_.set_up(pairs, solid_pairs, solids, layer, step, role, mu);
    solve_implicit(operator_, options_.limits, {step, report, role, x, u, last});
}

}  // namespace whorl
