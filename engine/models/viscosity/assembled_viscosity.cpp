#include "engine/models/viscosity/assembled_viscosity.h"

#include <cmath>

#include "engine/core/parallel.h"
#include "engine/models/bodies/reaction.h"
#include "engine/models/boundary/wall.h"
#include "engine/models/viscosity/strain/moment.h"

namespace whorl {
namespace {

/// grad W_ij = W'(|r|) r/|r|; zero if the two positions coincide.
template <class Kernel>
Vec3 kernel_gradient(const Kernel& kernel, const Vec3& r, Real distance) {
    return distance > 0 ? Vec3((kernel.derivative(distance) / distance) * r) : Vec3(Vec3::Zero());
}

}  // namespace

/// Gradients from which the coefficients are formed.
struct AssembledOperator::Gradients {
    Column<Vec3> gradW;         ///< of each pair
    Column<Vec3> solid_gradW;   ///< of each pair with a solid, times stretch and times V_s/(volume at rest); 0 if the fluid slips
    Column<Real> stretch;       ///< of each pair with a solid, see models/boundary/wall.h
    Column<Real> spring;        ///< of each pair, V |W'|/r; empty: no penalty
    Column<Vec3> omega, alpha;  ///< sum_j grad W_ij and sum_j a_ij
    Column<Real> stress;        ///< m^ mu^_i
    Column<Real> volume;        ///< m/rho_i
    Real rest_volume = 0;
    bool own_volume = true;
    /// The penalty uses the gradient (grad u) L. At a wall the strain rate, sym(P (grad u) L), uses the same gradient.
    struct Penalty {
        Mat3 L = Mat3::Zero(), P = Mat3::Identity();
        Real twice = 0, springs = 0;  ///< 2 c, see viscous_operator.h; 2 c sum_s V |W'|/r stretch^2
    };
    Column<Penalty> penalty;  ///< empty: none
    bool at_wall(Index i) const { return !penalty.empty() && penalty[i].springs > 0; }
    bool own(Index i) const { return own_volume || at_wall(i); }
    /// a_ij = V_i grad W_ij, or V_j as printed.
    Vec3 a(Index i, Index j, std::size_t pair) const { return volume[own(i) ? i : j] * gradW[pair]; }
    Vec3 solid_a(Index i, std::size_t pair) const { return (own(i) ? volume[i] : rest_volume) * solid_gradW[pair]; }
    /// m^ mu^_i times the nine coefficients, from the energy of particle i.
    Mat3 coefficients(Index i, const Vec3& b, const Vec3& a) const {
        if (penalty.empty()) return stress[i] * nine_coefficients(b, a);
        const Penalty& p = penalty[i];
        const Vec3 La = p.L * a;
        Mat3 c = stress[i] * nine_coefficients(b, a);
        if (p.springs > 0) c = stress[i] * p.P * nine_coefficients(p.L * b, La) * p.P;
        c.diagonal().array() -= p.twice * rest_volume * b.dot(La);
        return c;
    }
    /// m^ mu^_i Q_i for A = sum_j (u_i - u_j) a_ij^T.
    Mat3 stress_of(Index i, const Mat3& A, const Mat3& T = Mat3::Zero()) const {
        Mat3 Q = stress[i] * (2 * T + A + A.transpose());
        if (penalty.empty()) return Q;
        const Penalty& p = penalty[i];
        const Mat3 G = p.P * A * p.L;
        if (p.springs > 0) Q = stress[i] * p.P * (2 * p.P * T * p.P + G + G.transpose()) * p.L;
        return Q - p.twice * rest_volume * A * p.L;
    }
    /// 2 c V |W'|/r stretch^2 of a pair with a solid.
    Real solid_spring(Index i, std::size_t pair, Real distance) const {
        return at_wall(i) && distance > 0 ? penalty[i].twice * rest_volume * solid_gradW[pair].norm() * stretch[pair] / distance : 0;
    }
    /// Velocity of a solid as a neighbour, divided by stretch, which continues the shear behind the surface.
    Vec3 velocity(const InteractionContext& context, Index s, const Vec3& r, std::size_t pair) const {
        const Pose& pose = context.solids.all[context.boundary.solid[s]].pose;
        const Vec3 x = context.boundary.position[s];
        const Vec3 there = pose.velocity_over(context.step.dt, x);
        return stretch[pair] == 1 ? there
                                  : Vec3(((stretch[pair] - 1) * pose.velocity_over(context.step.dt, x + r) + there) / stretch[pair]);
    }
};

void AssembledOperator::set_up(const ViscosityOptions& options, const InteractionContext& context, Read<field::role> role,
                               Read<field::density> rho, Read<field::viscosity> mu, Span<const Mat3> before) {
    const StepContext& step = context.step;
    const std::size_t n = static_cast<std::size_t>(mu.size());
    Gradients g;
    g.rest_volume = step.volume;
    g.own_volume = !options.printed;
    printed_ = options.printed;
    g.gradW.resize(context.pairs.other.size());
    g.omega.resize(n), g.alpha.resize(n), g.stress.resize(n), g.volume.resize(n);
    parallel_for(mu.size(), [&](Index i) {
        g.volume[i] = step.mass / rho[i];
        g.stress[i] = step.mass * step.dt * mu[i] / (rho[i] * rho[i]);
        if (options.share != 1) g.stress[i] *= options.share;
    });
    const std::vector<char> slip = slips(context.solids);
    const bool walls = context.boundary.size() > 0, springs_act = options.penalty > 0;
    if (walls) g.solid_gradW.resize(context.solid_pairs.other.size()), g.stretch.resize(context.solid_pairs.other.size());
    if (springs_act) g.spring.resize(g.gradW.size()), g.penalty.resize(n);
    const WallShear shear{step.spacing / 2};
    with_kernel(step.kernel, step.support, [&](const auto& kernel) {
        parallel_for(mu.size(), [&](Index i) {
            Vec3 omega = Vec3::Zero(), alpha = Vec3::Zero();
            Mat3d moment = Mat3d::Zero();
            Real springs = 0;
            std::size_t k = context.pairs.first[i];
            context.pairs.of(i, [&](Index, const Vec3& r, Real distance) {
                g.gradW[k] = kernel_gradient(kernel, r, distance);
                if (springs_act) {
                    g.spring[k] = distance > 0 ? step.volume * g.gradW[k].norm() / distance : 0;
                    moment += (g.spring[k] * r * r.transpose()).template cast<double>();
                }
                omega += g.gradW[k++];
            });
            if (walls) {
                k = context.solid_pairs.first[i];
                const Real factor = options.solid_factor *
                                    options.gate.weight(kernel, i, context.solid_pairs, context.boundary.volume, options.solid_factor);
                context.solid_pairs.of(i, [&](Index s, const Vec3& r, Real distance) {
                    const Real volume = slip[context.boundary.solid[s]] ? 0 : factor * context.boundary.volume[s];
                    const Vec3 gradW = volume / step.volume * kernel_gradient(kernel, r, distance);
                    g.stretch[k] = springs_act ? shear.stretch(r, context.boundary.normal[s]) : 1;
                    g.solid_gradW[k] = g.stretch[k] * gradW;
                    omega += g.solid_gradW[k];
                    if (const Real w = distance > 0 ? step.volume * gradW.norm() / distance : 0; springs_act && w > 0) {
                        moment += (w * r * r.transpose()).template cast<double>();
                        springs += g.stretch[k] * g.stretch[k] * w;
                    }
                    ++k;
                });
            }
            if (springs_act && moment.trace() > 0) {
                const Moment m = invert_moment(moment, kernel.dimensions);
                const Real c = options.penalty * g.stress[i] / g.volume[i] * static_cast<Real>(kernel.dimensions / moment.trace());
                g.penalty[i] = {m.inverse.cast<Real>() * step.volume / g.volume[i], m.resolved.cast<Real>(), 2 * c, 2 * c * springs};
            }
            for (k = context.pairs.first[i]; k < context.pairs.first[i + 1]; ++k) alpha += g.a(i, context.pairs.other[k], k);
            if (walls)
                for (k = context.solid_pairs.first[i]; k < context.solid_pairs.first[i + 1]; ++k) alpha += g.solid_a(i, k);
            g.omega[i] = omega;
            g.alpha[i] = alpha;
        });
    });
    free_.resize(n);
    for (std::size_t i = 0; i < n; ++i) free_[i] = role.values[i] == 0;
    touches_wall_ = parallel_sum(static_cast<Index>(g.solid_gradW.size()), [&](Index k) { return g.solid_gradW[k] != Vec3::Zero(); }) > 0;
    assemble(g, context.pairs);
    known_force_.clear();
    gradients_.reset();
    if (touches_wall_ || !before.empty()) set_known_force(g, context, before);
    Column<Mat3> blocks(n);
    parallel_for(mu.size(), [&](Index i) { blocks[i] = block(i, i); });
    diagonal_.set(std::move(blocks), free_);
    if (touches_wall_ && context.solids.any_probed()) gradients_ = std::make_shared<const Gradients>(std::move(g));
}

// Q_i = m^ mu^_i (2 T_i - grad u_i - (grad u_i)^T). A boundary particle receives Q_i grad W_is and the penalty's pull from i.
void AssembledOperator::write_ledgers(const ImplicitStep& step, Span<const Vec3> u) const {
    if (!gradients_) return;
    const InteractionContext& context = step.context;
    const Gradients& g = *gradients_;
    react(context, Push::viscous, step.role, context.step.mass, [&](Index i) {
        Mat3 a = u[i] * g.alpha[i].transpose();
        for (std::size_t k = context.pairs.first[i]; k < context.pairs.first[i + 1]; ++k) {
            const Index j = context.pairs.other[k];
            a -= u[j] * g.a(i, j, k).transpose();
        }
        const Mat3 Q = known_stress_[i] + g.stress_of(i, a);
        return [&, i, Q](Index s, const Vec3& r, Real distance) {
            std::size_t k = context.solid_pairs.first[i];
            while (context.solid_pairs.other[k] != s) ++k;
            const Vec3 pull = g.solid_spring(i, k, distance) * (u[i] - g.velocity(context, s, r, k));
            return PushAt(-(Q * g.solid_gradW[k]) - pull, g.at_wall(i) ? Vec3(r / g.stretch[k]) : Vec3(Vec3::Zero()));
        };
    });
}

void AssembledOperator::assemble(const Gradients& g, const FluidPairs& pairs) {
    const Index n = static_cast<Index>(g.omega.size());
    rows_.assign((n + rows_size - 1) / rows_size, {});
    own_.resize(g.omega.size());
    parallel_blocks(n, rows_size, [&](Index begin, Index end) {
        Rows& rows = rows_[begin / rows_size];
        std::vector<std::ptrdiff_t> place(g.omega.size(), -1);  // position of a particle in the row, -1: not in it
        const auto add = [&](Index j, const Mat3& c) {
            if (place[j] < 0) {
                place[j] = static_cast<std::ptrdiff_t>(rows.other.size());
                rows.other.push_back(j);
                rows.block.push_back(c);
            } else {
                rows.block[place[j]] += c;
            }
        };
        for (Index i = begin; i < end; ++i) {
            rows.first.push_back(rows.other.size());
            own_[i] = Mat3::Identity() + g.coefficients(i, g.omega[i], g.alpha[i]);
            add(i, own_[i]);
            Real springs = g.penalty.empty() ? 0 : g.penalty[i].springs;
            for (std::size_t e = pairs.first[i]; e < pairs.first[i + 1]; ++e) {
                const Index j = pairs.other[e];
                const Vec3& gradW = g.gradW[e];
                add(j, g.coefficients(j, gradW, g.alpha[j]) - g.coefficients(i, g.omega[i], g.a(i, j, e)));
                if (!g.penalty.empty()) {
                    const Real spring = (g.penalty[i].twice + g.penalty[j].twice) * g.spring[e];
                    add(j, -spring * Mat3::Identity());
                    springs += spring;
                }
                for (std::size_t f = pairs.first[j]; f < pairs.first[j + 1]; ++f) {
                    const Index k = pairs.other[f];
                    add(k, -g.coefficients(j, gradW, g.a(j, k, f)));
                }
            }
            if (springs > 0) add(i, springs * Mat3::Identity());
            for (std::size_t e = rows.first.back(); e < rows.other.size(); ++e) place[rows.other[e]] = -1;
        }
        rows.first.push_back(rows.other.size());
    });
}

/// Sets m^ sum_j (mu^_i Q_i + mu^_j Q_j) grad W_ij of T and the velocities of the solids alone.
void AssembledOperator::set_known_force(const Gradients& g, const InteractionContext& context, Span<const Mat3> before) {
    const Index n = size();
    Column<Mat3> Q(n);
    known_force_.assign(n, Vec3::Zero());
    parallel_for(n, [&](Index i) {
        Mat3 A = Mat3::Zero();
        std::size_t k = touches_wall_ ? context.solid_pairs.first[i] : 0;
        if (touches_wall_)
            context.solid_pairs.of(i, [&](Index s, const Vec3& r, Real distance) {
                const Vec3 velocity = g.velocity(context, s, r, k);
                A -= velocity * g.solid_a(i, k).transpose();
                known_force_[i] -= g.solid_spring(i, k++, distance) * velocity;
            });
        Q[i] = g.stress_of(i, A, before.empty() ? Mat3(Mat3::Zero()) : curvature_strain(before[i], context.step.dt));
    });
    parallel_for(n, [&](Index i) {
        Vec3 sum = known_force_[i] + Q[i] * g.omega[i];
        for (std::size_t k = context.pairs.first[i]; k < context.pairs.first[i + 1]; ++k) sum += Q[context.pairs.other[k]] * g.gradW[k];
        known_force_[i] = sum;
    });
    if (context.solids.any_probed()) known_stress_ = std::move(Q);
}

Mat3 AssembledOperator::block(Index i, Index j) const {
    const Rows& rows = rows_[i / rows_size];
    for (std::size_t e = rows.first[i % rows_size]; e < rows.first[(i % rows_size) + 1]; ++e)
        if (rows.other[e] == j) return rows.block[e];
    return Mat3::Zero();
}

Vec3 AssembledOperator::row_times(Index i, Span<const Vec3> u, bool free_only) const {
    const Rows& rows = rows_[i / rows_size];
    Vec3 sum = Vec3::Zero();
    for (std::size_t e = rows.first[i % rows_size]; e < rows.first[(i % rows_size) + 1]; ++e) {
        const std::size_t j = static_cast<std::size_t>(rows.other[e]);
        if (free_only && !free_[j]) continue;
        sum += rows.block[e] * u[j];
    }
    return sum;
}

void AssembledOperator::multiply(Span<const Vec3> u, Span<Vec3> y) const {
    parallel_for(size(), [&](Index i) { y[i] = free_[i] ? row_times(i, u, true) : Vec3(Vec3::Zero()); });
}

void AssembledOperator::force(Span<const Vec3> u, Span<Vec3> y) const {
    parallel_for(size(), [&](Index i) {
        y[i] = row_times(i, u, false);
        if (!known_force_.empty()) y[i] += known_force_[i];
    });
}

std::size_t AssembledOperator::bytes() const {
    std::size_t sum = 0;
    for (const Rows& rows : rows_) sum += rows.other.capacity() * sizeof(Index) + rows.block.capacity() * sizeof(Mat3);
    return sum;
}

double assembled_bytes(double reach, int dimensions) {
    double entries = 0;
    each_lattice_point(dimensions, static_cast<int>(std::floor(2 * reach)),
                       [&](int x, int y, int z) { entries += x * x + y * y + z * z < 4 * reach * reach; });
    return entries * (sizeof(Mat3) + sizeof(Index));
}

}  // namespace whorl
