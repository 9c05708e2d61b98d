#include "engine/models/viscosity/viscous_operator.h"

#include <limits>

#include "engine/core/parallel.h"
#include "engine/models/viscosity/sticking_walls.h"
#include "engine/models/viscosity/strain/curvature.h"
#include "engine/models/viscosity/strain/moment.h"

namespace whorl {

void ViscousOperator::set_up(const ViscosityOptions& options, const InteractionContext& context, Read<field::role> role,
                             Read<field::viscosity> mu, Span<const Real> density, Span<const Mat3> before) {
    const std::size_t n = static_cast<std::size_t>(mu.size());
    pairs_ = &context.pairs;
    options_ = options;
    dimensions_ = context.step.dimensions();
    use_coarse(nullptr);
    resize_tightly(weight_, context.pairs.other.size());
    M_.resize(n), P_.resize(n), K_.resize(n), c_.resize(n), wr_.resize(n), free_.resize(n), whole_.resize(n);
    u_.resize(n), Q_.resize(n), own_.resize(n);
    touches_wall_ = false;
    wall_.clear(), wall_moment_.clear();
    dt_nu_.resize(n);
    friction_.set(FrictionForm::central, context, options.gate, options.solid_factor);
    if (context.boundary.size() > 0) set_up_wall(options, context);
    set_up_bodies(options, context);
    set_up_moments(options, context.step, role, mu, density);
    set_up_curvature(before, context.step.dt);
    set_up_blocks(options, context.step.spacing);
    if (bodies()) set_up_body_blocks();
}

void ViscousOperator::set_up_moments(const ViscosityOptions& options, const StepContext& step, Read<field::role> role,
                                     Read<field::viscosity> mu, Span<const Real> density) {
    with_kernel(step.kernel, step.support, [&](const auto& kernel) {
        parallel_for(mu.size(), [&](Index i) {
            Real xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0, gx = 0, gy = 0, gz = 0;
            std::size_t k = pairs_->first[i];
            pairs_->groups_of(i, [&](const Pairs::Group& group) {
                for (Index l = 0; l < group.count; ++l) {
                    const Real x = group.r[0][l], y = group.r[1][l], z = group.r[2][l], distance = group.distance[l];
                    const Real w = -step.volume * kernel.derivative(distance) / std::max(distance, std::numeric_limits<Real>::min());
                    weight_[k++] = w;
                    xx += w * x * x, xy += w * x * y, xz += w * x * z, yy += w * y * y, yz += w * y * z, zz += w * z * z;
                    gx += w * x, gy += w * y, gz += w * z;
                }
            });
            Mat3d M;
            M << xx, xy, xz, xy, yy, yz, xz, yz, zz;
            wr_[i] = {Vec3(gx, gy, gz), 0};
            if (!wall_.empty()) M += wall_moment_[i], wr_[i].wr += wall_[i].near.wr;
            free_[i] = role[i] == 0;
            K_[i] = step.dt * mu[i] / step.rest_density;
            if (options.share != 1) K_[i] *= options.share;
            if (friction_.acts()) dt_nu_[i] = K_[i], K_[i] *= 1 - friction_.counted(i);
            const Real compression = options.correction || density.empty() ? 1 : density[i] / step.rest_density;
            K_[i] /= compression;  // dt mu V_i/m
            c_[i] = 0;
            P_[i].set(Mat3::Identity());
            whole_[i] = 1;
            if (options.stretches()) {
                const Moment moment = invert_moment(M, kernel.dimensions);
                whole_[i] = moment.whole;
                M_[i].set(moment.inverse.cast<Real>());
                P_[i].set(moment.resolved.cast<Real>());
                if (M.trace() > 0) c_[i] = options.penalty * K_[i] * static_cast<Real>(kernel.dimensions / M.trace());
                if (!soft_.empty()) {
                    Real softest = soft_[i];
                    for (std::size_t e = pairs_->first[i]; e < pairs_->first[i + 1]; ++e)
                        softest = std::min(softest, soft_[pairs_->other[e]]);
                    c_[i] *= std::min(Real(1), softest / mu[i]);
                }
            }
            if (!options.correction && (!options.stretches() || wall_.empty() || !(wall_[i].near.spring > 0))) {
                whole_[i] = 2, P_[i] = M_[i];
                M_[i].set(Mat3::Identity() / compression);  // V_i/V
            }
            if (!wall_.empty()) {
                Wall& wall = wall_[i];
                wall.near.spring *= 2 * c_[i];
                wall.moving.set(wall.moving.matrix(), 2 * c_[i] * wall.moving.beside());
            }
        });
    });
}

void ViscousOperator::set_up_wall(const ViscosityOptions& options, const InteractionContext& context) {
    wall_.assign(K_.size(), {});
    wall_moment_.assign(K_.size(), Mat3d::Zero());
    std::vector<char> touches(K_.size(), 0);
    with_kernel(context.step.kernel, context.step.support, [&](const auto& kernel) {
        const StickingWalls walls(kernel, context, options);
        parallel_for(context.solid_pairs.size(), [&](Index i) {
            Wall& wall = wall_[i];
            Mat3 gradient = Mat3::Zero();
            Vec3 pull = Vec3::Zero();
            const Real factor = walls.factor(i);
            context.solid_pairs.of(i, [&](Index s, const Vec3& r, Real distance) {
                const Real w = walls.weight(factor, s, distance), stretch = walls.stretch(s, r);
                if (!(w > 0)) return;
                wall_moment_[i] += (w * r * r.transpose()).template cast<double>();
                wall.near.wr += stretch * w * r;
                wall.near.spring += stretch * stretch * w;
                if (walls.solid(s).body) return;  // its velocity is unknown (viscous_bodies.h)
                touches[i] = 1;
                const Vec3 velocity = walls.velocity(s, r, stretch);
                gradient += velocity * (w * r).transpose();
                pull += stretch * w * velocity;
            });
            wall.moving.set(gradient, pull);
        });
    });
    touches_wall_ = friction_.acts() || std::find(touches.begin(), touches.end(), 1) != touches.end();
}

void ViscousOperator::set_up_curvature(Span<const Mat3> before, Real dt) {
    curvature_.resize(before.size());
    parallel_for(static_cast<Index>(before.size()), [&](Index i) {
        const Mat3 T = 2 * curvature_strain(before[i], dt);
        const Mat3 P = P_[i].matrix();
        curvature_[i].set(whole_[i] ? T : Mat3(P * P * T * P));
    });
}

/// dt nu/d^2 up to which B = 1 needs no more iterations than the blocks, whose set-up costs two products.
constexpr double one_above = 0.15;

/// B_i = 1 + K_i P_i (|h|^2 + h h^T) P_i + 2 c_i (sum w - g.M_i^+ g)            from the energy of i; g = sum_j w r_ij, h = M_i^+ g
///         + sum_j K_j P_j (|h_j|^2 + h_j h_j^T) P_j + 2 c_j (w - w r.M_j^+ w r)   from the energies of neighbours j; h_j = M_j^+ w r_ij
void ViscousOperator::set_up_blocks(const ViscosityOptions& options, double d) {
    const auto strain_block = [&](Index j, const Vec3& g, Mat3& B) {
        const Vec3 h = M_[j].matrix() * g;
        Mat3 S = h * h.transpose();
        S.diagonal().array() += h.squaredNorm();
        if (whole_[j]) B += K_[j] * S;
        else B += K_[j] * P_[j].matrix() * S * P_[j].matrix();
        return whole_[j] == 2 ? g.dot(P_[j].matrix() * g) : h.dot(g);
    };
    Column<Mat3> blocks(K_.size(), Mat3(Mat3::Identity()));
    const bool automatic = options.preconditioner == ViscousPreconditioner::automatic;
    const bool easy = automatic && !touches_wall_ && !bodies() && largest_spread() < one_above * d * d;
    if (easy || options.preconditioner == ViscousPreconditioner::none) return diagonal_.set(std::move(blocks), free_);
    parallel_for(size(), [&](Index i) {
        Mat3 B = Mat3::Identity();
        const Real own = c_[i];
        Real springs = wall_.empty() ? 0 : wall_[i].near.spring, seen = 0;
        each_pair(i, [&](Index j, const Pair& pair) {
            seen += 2 * c_[j] * strain_block(j, pair.wr, B);
            springs += pair.spring;
        });
        seen += 2 * own * strain_block(i, wr_[i].wr, B);
        B.diagonal().array() += std::max(Real(0), springs - seen);
        if (friction_.acts()) B += friction_coefficient(i);
        blocks[i] = B;
    });
    diagonal_.set(std::move(blocks), free_);
}

double ViscousOperator::largest_spread() const {
    return parallel_max(size(), 0, [&](Index i) { return K_[i]; });
}

void ViscousOperator::precondition(Span<const Vec3> r, Span<Vec3> z) const {
    divide_by_diagonal(r, z);
    if (coarse_) coarse_->add(r, z);
}

}  // namespace whorl
