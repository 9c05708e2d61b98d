#include "engine/models/viscosity/assembled.h"

#include <cmath>

#include "engine/core/parallel.h"
#include "engine/models/boundary/wall.h"
#include "engine/sph/operators.h"

namespace whorl {
namespace {

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

}  // namespace

/// What the coefficients are made of.
struct AssembledOperator::Gradients {
    Column<Vec3> gradW;         ///< of each pair
    Column<Vec3> solid_gradW;   ///< of each pair with a solid, times its volume over that of the fluid at rest; 0 where the fluid slips
    Column<Vec3> omega, alpha;  ///< sum_j grad W_ij and sum_j a_ij
    Column<Real> stress;        ///< m^ mu^_i
    Column<Real> volume;        ///< m/rho_i
    Real rest_volume = 0;
    bool own_volume = true;
    /// a_ij = V_i grad W_ij, or V_j as printed.
    Vec3 a(Index i, Index j, std::size_t pair) const { return volume[at(own_volume ? i : j)] * gradW[pair]; }
    Vec3 solid_a(Index i, std::size_t pair) const { return (own_volume ? volume[at(i)] : rest_volume) * solid_gradW[pair]; }
};

void AssembledOperator::set_up(const AssembledViscosityOptions& options, const FluidPairs& pairs, const SolidPairs& solid_pairs,
                               const Solids& solids, const SolidParticles& layer, const StepContext& step, Read<field::role> role,
                               Read<field::density> rho, Read<field::viscosity> mu) {
    const std::size_t n = at(mu.size());
    Gradients g;
    g.rest_volume = step.volume;
    g.own_volume = options.own_volume;
    g.gradW.resize(pairs.other.size());
    g.omega.resize(n), g.alpha.resize(n), g.stress.resize(n), g.volume.resize(n);
    parallel_for(mu.size(), [&](Index i) {
        g.volume[at(i)] = step.mass / rho[i];
        g.stress[at(i)] = step.mass * step.dt * mu[i] / (rho[i] * rho[i]);
    });
    const bool walls = layer.size() > 0;
    if (walls) g.solid_gradW.resize(solid_pairs.other.size());
    const std::vector<char> slip = slips(solids);
    with_kernel(step.kernel, step.support, [&](const auto& kernel) {
        parallel_for(mu.size(), [&](Index i) {
            Vec3 omega = Vec3::Zero(), alpha = Vec3::Zero();
            std::size_t k = pairs.first[at(i)];
            pairs.of(i, [&](Index j, const Vec3& r, Real distance) {
                g.gradW[k] = kernel_gradient(kernel, r, distance);
                omega += g.gradW[k];
                alpha += g.a(i, j, k++);
            });
            if (walls) {
                k = solid_pairs.first[at(i)];
                solid_pairs.of(i, [&](Index s, const Vec3& r, Real distance) {
                    const Real volume = slip[at(layer.solid[at(s)])] ? 0 : options.solid_factor * layer.volume[at(s)];
                    g.solid_gradW[k] = volume / step.volume * kernel_gradient(kernel, r, distance);
                    omega += g.solid_gradW[k];
                    alpha += g.solid_a(i, k++);
                });
            }
            g.omega[at(i)] = omega;
            g.alpha[at(i)] = alpha;
        });
    });
    free_.resize(n);
    for (std::size_t i = 0; i < n; ++i) free_[i] = role.values[i] == 0;
    touches_wall_ =
        parallel_sum(static_cast<Index>(g.solid_gradW.size()), [&](Index k) { return g.solid_gradW[at(k)] != Vec3::Zero(); }) > 0;
    assemble(g, pairs);
    wall_force_.clear();
    if (touches_wall_) set_wall_force(g, pairs, solid_pairs, layer);
    Column<Mat3> blocks(n);
    parallel_for(mu.size(), [&](Index i) { blocks[at(i)] = block(i, i); });
    diagonal_.set(std::move(blocks), free_);
}

void AssembledOperator::assemble(const Gradients& g, const FluidPairs& pairs) {
    const Index n = static_cast<Index>(g.omega.size());
    rows_.assign(at((n + rows_size - 1) / rows_size), {});
    own_.resize(g.omega.size());
    parallel_blocks(n, rows_size, [&](Index begin, Index end) {
        Rows& rows = rows_[at(begin / rows_size)];
        std::vector<std::ptrdiff_t> place(g.omega.size(), -1);  // of a particle in the row, -1: not in it
        const auto add = [&](Index j, const Mat3& c) {
            if (place[at(j)] < 0) {
                place[at(j)] = static_cast<std::ptrdiff_t>(rows.other.size());
                rows.other.push_back(j);
                rows.block.push_back(c);
            } else {
                rows.block[static_cast<std::size_t>(place[at(j)])] += c;
            }
        };
        for (Index i = begin; i < end; ++i) {
            rows.first.push_back(rows.other.size());
            own_[at(i)] = Mat3::Identity() + g.stress[at(i)] * nine_coefficients(g.omega[at(i)], g.alpha[at(i)]);
            add(i, own_[at(i)]);
            for (std::size_t e = pairs.first[at(i)]; e < pairs.first[at(i) + 1]; ++e) {
                const Index j = pairs.other[e];
                const Vec3& gradW = g.gradW[e];
                add(j, g.stress[at(j)] * nine_coefficients(gradW, g.alpha[at(j)]) -
                           g.stress[at(i)] * nine_coefficients(g.omega[at(i)], g.a(i, j, e)));
                for (std::size_t f = pairs.first[at(j)]; f < pairs.first[at(j) + 1]; ++f) {
                    const Index k = pairs.other[f];
                    add(k, -g.stress[at(j)] * nine_coefficients(gradW, g.a(j, k, f)));
                }
            }
            for (std::size_t e = rows.first.back(); e < rows.other.size(); ++e) place[at(rows.other[e])] = -1;
        }
        rows.first.push_back(rows.other.size());
    });
}

/// m^ sum_j (mu^_i Q_i + mu^_j Q_j) grad W_ij of the velocities of the solids alone.
void AssembledOperator::set_wall_force(const Gradients& g, const FluidPairs& pairs, const SolidPairs& solid_pairs,
                                       const SolidParticles& layer) {
    const Index n = size();
    Column<Mat3> Q(at(n));
    parallel_for(n, [&](Index i) {
        Mat3 gradient = Mat3::Zero();
        for (std::size_t k = solid_pairs.first[at(i)]; k < solid_pairs.first[at(i) + 1]; ++k)
            gradient += layer.velocity[at(solid_pairs.other[k])] * g.solid_a(i, k).transpose();
        Q[at(i)] = -g.stress[at(i)] * (gradient + gradient.transpose());
    });
    wall_force_.resize(at(n));
    parallel_for(n, [&](Index i) {
        Vec3 sum = Q[at(i)] * g.omega[at(i)];
        for (std::size_t k = pairs.first[at(i)]; k < pairs.first[at(i) + 1]; ++k) sum += Q[at(pairs.other[k])] * g.gradW[k];
        wall_force_[at(i)] = sum;
    });
}

Mat3 AssembledOperator::block(Index i, Index j) const {
    const Rows& rows = rows_[at(i / rows_size)];
    for (std::size_t e = rows.first[at(i % rows_size)]; e < rows.first[at(i % rows_size) + 1]; ++e)
        if (rows.other[e] == j) return rows.block[e];
    return Mat3::Zero();
}

Vec3 AssembledOperator::row_times(Index i, Span<const Vec3> u, bool free_only) const {
    const Rows& rows = rows_[at(i / rows_size)];
    Vec3 sum = Vec3::Zero();
    for (std::size_t e = rows.first[at(i % rows_size)]; e < rows.first[at(i % rows_size) + 1]; ++e) {
        const std::size_t j = at(rows.other[e]);
        if (free_only && !free_[j]) continue;
        sum += rows.block[e] * u[j];
    }
    return sum;
}

void AssembledOperator::multiply(Span<const Vec3> u, Span<Vec3> y) const {
    parallel_for(size(), [&](Index i) { y[at(i)] = free_[at(i)] ? row_times(i, u, true) : Vec3(Vec3::Zero()); });
}

void AssembledOperator::force(Span<const Vec3> u, Span<Vec3> y) const {
    parallel_for(size(), [&](Index i) {
        y[at(i)] = row_times(i, u, false);
        if (!wall_force_.empty()) y[at(i)] += wall_force_[at(i)];
    });
}

std::size_t AssembledOperator::bytes() const {
    std::size_t sum = 0;
    for (const Rows& rows : rows_) sum += rows.other.capacity() * sizeof(Index) + rows.block.capacity() * sizeof(Mat3);
    return sum;
}

double assembled_bytes(double reach) {
    const int most = static_cast<int>(std::floor(2 * reach));
    double entries = 0;
    for (int x = -most; x <= most; ++x)
        for (int y = -most; y <= most; ++y)
            for (int z = -most; z <= most; ++z) entries += x * x + y * y + z * z < 4 * reach * reach;
    return entries * (sizeof(Mat3) + sizeof(Index));
}

void AssembledViscosity::operator()(const FluidPairs& pairs, const SolidPairs& solid_pairs, const Solids& solids,
                                    const SolidParticles& layer, const StepContext& step, StepReport& report, Read<field::role> role,
                                    Read<field::position> x, Read<field::density> rho, Read<field::viscosity> mu, Update<field::velocity> u,
                                    Update<field::viscous_acceleration> last) {
    operator_.set_up(options_, pairs, solid_pairs, solids, layer, step, role, rho, mu);
    solve_implicit(operator_, options_.limits, {step, report, role, x, u, last});
}

}  // namespace whorl
