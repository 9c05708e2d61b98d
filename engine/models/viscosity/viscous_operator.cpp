#include <Eigen/Eigenvalues>
#include <limits>

#include "engine/core/parallel.h"
#include "engine/models/boundary/wall.h"
#include "engine/models/viscosity/full.h"

namespace whorl {
namespace {

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

/// M^+ and P of the matrix M of a neighbourhood. A direction counts as resolved by a smooth step of its eigenvalue over the largest, from 0.01 to
/// 0.04: neighbours on a line or in a plane, or a single one, tell nothing about the directions across. Returns whether all three are resolved.
bool pseudo_inverse(const Mat3d& M, Mat3d& inverse, Mat3d& projection) {
    const Eigen::SelfAdjointEigenSolver<Mat3d> axes(M);
    const Vec3d s = axes.eigenvalues();
    inverse = projection = Mat3d::Zero();
    if (!(s[2] > 0)) return false;
    bool whole = true;
    for (int a = 0; a < 3; ++a) {
        const double t = std::log(std::max(s[a] / s[2], 1e-30) / 0.01) / std::log(4.0);
        const double c = std::min(1.0, std::max(0.0, t)), resolved = c * c * (3 - 2 * c);
        whole = whole && resolved == 1;
        if (resolved == 0) continue;
        const Mat3d along = axes.eigenvectors().col(a) * axes.eigenvectors().col(a).transpose();
        inverse += resolved / s[a] * along;
        projection += resolved * along;
    }
    return whole;
}

}  // namespace

void ViscousOperator::set_up(const FullViscosityOptions& options, const FluidPairs& pairs, const SolidPairs& solid_pairs, const Solids& solids,
                             const SolidParticles& layer, const StepContext& step, Read<field::role> role, Read<field::viscosity> mu,
                             Span<const Real> density) {
    const std::size_t n = at(mu.size());
    pairs_ = &pairs;
    solid_pairs_ = layer.size() > 0 ? &solid_pairs : nullptr;
    pair_.resize(pairs.other.size());
    corrected_ = options.correction;
    M_.resize(n), P_.resize(n);
    K_.resize(n), c_.resize(n), free_.resize(n), whole_.resize(n), u_.resize(n), Q_.resize(n);

    touches_wall_ = false;
    if (solid_pairs_) set_up_wall(options, solid_pairs, solids, layer, step);

    with_kernel(step.kernel, step.support, [&](const auto& kernel) {
        parallel_for(mu.size(), [&](Index i) {
            Mat3d M = Mat3d::Zero();
            const auto add = [&](const Vec4& w) {
                if (!(w[3] > 0)) return;
                const Vec3d wr = w.head<3>().matrix().template cast<double>();
                M += wr * wr.transpose() / static_cast<double>(w[3]);
            };
            std::size_t k = pairs.first[at(i)];
            pairs.of(i, [&](Index, const Vec3& r, Real distance) {
                const Real w = -step.volume * kernel.derivative(distance) / std::max(distance, std::numeric_limits<Real>::min());
                pair_[k] << w * r[0], w * r[1], w * r[2], w;
                add(pair_[k++]);
            });
            if (solid_pairs_)
                for (std::size_t s = solid_pairs.first[at(i)]; s < solid_pairs.first[at(i) + 1]; ++s) add(wall_pair_[s]);
            free_[at(i)] = role[i] == 0;
            K_[at(i)] = step.dt * mu[i] / step.rest_density;
            c_[at(i)] = 0;
            M_[at(i)] = P_[at(i)] = Mat3::Identity();
            whole_[at(i)] = 1;
            if (!options.correction) {
                const Real compression = density.empty() ? 1 : density[at(i)] / step.rest_density;
                M_[at(i)] /= compression;  // V_i/V
                K_[at(i)] /= compression;  // dt mu V_i/m
                return;
            }
            Mat3d inverse, projection;
            whole_[at(i)] = pseudo_inverse(M, inverse, projection);
            M_[at(i)] = inverse.cast<Real>();
            P_[at(i)] = projection.cast<Real>();
            if (M.trace() > 0) c_[at(i)] = options.penalty * K_[at(i)] * static_cast<Real>(3 / M.trace());
        });
    });
    set_up_blocks();
}

void ViscousOperator::set_up_wall(const FullViscosityOptions& options, const SolidPairs& solid_pairs, const Solids& solids, const SolidParticles& layer,
                                  const StepContext& step) {
    const std::vector<char> slip = slips(solids);
    const WallShear shear{step.spacing / 2};
    const std::size_t count = solid_pairs.other.size();
    wall_pair_.resize(count);
    wall_stretch_.resize(count);
    wall_velocity_.resize(count);
    with_kernel(step.kernel, step.support, [&](const auto& kernel) {
        parallel_for(solid_pairs.size(), [&](Index i) {
            std::size_t k = solid_pairs.first[at(i)];
            solid_pairs.of(i, [&](Index s, const Vec3& r, Real distance) {
                const auto whose = at(layer.solid[at(s)]);
                Real w = -options.solid_factor * layer.volume[at(s)] * kernel.derivative(distance) / std::max(distance, std::numeric_limits<Real>::min());
                if (slip[whose]) w = 0;
                const Real stretch = options.correction ? shear.stretch(r, layer.normal[at(s)]) : 1;
                // stretch (u_i - u_wall(x_i)) + (u_wall(x_i) - u_wall(x_s)), with the rigid motion of the solid u_wall
                const Vec3 here = solids.all[whose].pose.velocity_at(layer.position[at(s)] + r);
                wall_pair_[k] << w * r[0], w * r[1], w * r[2], w;
                wall_stretch_[k] = stretch;
                wall_velocity_[k++] = (stretch - 1) * here + layer.velocity[at(s)];
            });
        });
    });
    touches_wall_ = parallel_sum(static_cast<Index>(count), [&](Index k) { return wall_pair_[at(k)][3] > 0; }) > 0;
}

/// B_i = 1 + K_i P_i (|h|^2 + h h^T) P_i + 2 c_i (sum w - g.M_i^+ g)            own energy: g = sum_j w r_ij, h = M_i^+ g
///         + sum_j K_j P_j (|h_j|^2 + h_j h_j^T) P_j + 2 c_j (w - w r.M_j^+ w r)   that of the neighbours: h_j = M_j^+ w r_ij
void ViscousOperator::set_up_blocks() {
    const auto strain_block = [&](Index j, const Vec3& g, Mat3& B) {
        const Vec3 h = M_[at(j)] * g;
        Mat3 S = h * h.transpose();
        S.diagonal().array() += h.squaredNorm();
        if (whole_[at(j)]) B += K_[at(j)] * S;
        else B += K_[at(j)] * P_[at(j)] * S * P_[at(j)];
        return h.dot(g);
    };
    Column<Mat3> blocks(K_.size());
    parallel_for(size(), [&](Index i) {
        Mat3 B = Mat3::Identity();
        Vec3 g = Vec3::Zero();
        Real weight = 0, diagonal = 0;
        for (std::size_t k = pairs_->first[at(i)]; k < pairs_->first[at(i) + 1]; ++k) {
            const Index j = pairs_->other[k];
            const Vec3 wr = pair_[k].head<3>().matrix();
            const Real seen = strain_block(j, wr, B);
            diagonal += 2 * c_[at(j)] * std::max(Real(0), pair_[k][3] - seen);
            g += wr;
            weight += pair_[k][3];
        }
        if (solid_pairs_)
            for (std::size_t k = solid_pairs_->first[at(i)]; k < solid_pairs_->first[at(i) + 1]; ++k) {
                g += wall_stretch_[k] * wall_pair_[k].head<3>().matrix();
                weight += wall_stretch_[k] * wall_stretch_[k] * wall_pair_[k][3];
            }
        const Real seen = strain_block(i, g, B);
        diagonal += 2 * c_[at(i)] * std::max(Real(0), weight - seen);
        B.diagonal().array() += diagonal;
        blocks[at(i)] = B;
    });
    diagonal_.set(std::move(blocks), free_);
}

void ViscousOperator::load(Span<const Vec3> u, bool free_only) const {
    parallel_for(size(), [&](Index i) {
        if (free_only && !free_[at(i)]) u_[at(i)].setZero();
        else u_[at(i)] << u[at(i)][0], u[at(i)][1], u[at(i)][2], 0;
    });
}

void ViscousOperator::strain(bool with_walls) const {
    parallel_for(size(), [&](Index i) {
        // Columns of sum_j w u_ij r_ij^T.
        Vec4 x = Vec4::Zero(), y = Vec4::Zero(), z = Vec4::Zero();
        const Vec4 own = u_[at(i)];
        for (std::size_t k = pairs_->first[at(i)]; k < pairs_->first[at(i) + 1]; ++k) {
            const Vec4 u_ij = own - u_[at(pairs_->other[k])], w = pair_[k];
            x += w[0] * u_ij;
            y += w[1] * u_ij;
            z += w[2] * u_ij;
        }
        if (solid_pairs_)
            for (std::size_t k = solid_pairs_->first[at(i)]; k < solid_pairs_->first[at(i) + 1]; ++k) {
                Vec4 u_is = wall_stretch_[k] * own;
                if (with_walls) u_is.head<3>() -= wall_velocity_[k].array();
                const Vec4 w = wall_pair_[k];
                x += w[0] * u_is;
                y += w[1] * u_is;
                z += w[2] * u_is;
            }
        Mat3 B;
        B.col(0) = x.head<3>().matrix();
        B.col(1) = y.head<3>().matrix();
        B.col(2) = z.head<3>().matrix();
        const Mat3 G = B * M_[at(i)];
        Mat3 D = whole_[at(i)] ? G : Mat3(P_[at(i)] * G);
        D = (Real(0.5) * (D + D.transpose())).eval();
        if (!whole_[at(i)]) D = (P_[at(i)] * D).eval();
        const Real c = c_[at(i)];
        const Mat3 Q = 2 * K_[at(i)] * (D * M_[at(i)]) - 2 * c * G;
        Stress& stress = Q_[at(i)];
        for (int a = 0; a < 3; ++a) stress.column[a] << Q(0, a), Q(1, a), Q(2, a), 0;
        stress.column[0][3] = c;
    });
}

void ViscousOperator::divergence(bool with_walls, Span<const Vec3> u, Span<Vec3> y) const {
    parallel_for(size(), [&](Index i) {
        Vec4 sum = Vec4::Zero();
        const Vec4 own = u_[at(i)], Qx = Q_[at(i)].column[0], Qy = Q_[at(i)].column[1], Qz = Q_[at(i)].column[2];
        const Real c = Qx[3];
        for (std::size_t k = pairs_->first[at(i)]; k < pairs_->first[at(i) + 1]; ++k) {
            const Index j = pairs_->other[k];
            const Stress& other = Q_[at(j)];
            const Vec4 w = pair_[k];
            const Real cw = 2 * w[3] * (c + other.column[0][3]);
            sum += w[0] * (Qx + other.column[0]) + w[1] * (Qy + other.column[1]) + w[2] * (Qz + other.column[2]) + cw * (own - u_[at(j)]);
        }
        if (solid_pairs_)
            for (std::size_t k = solid_pairs_->first[at(i)]; k < solid_pairs_->first[at(i) + 1]; ++k) {
                const Vec4 w = wall_stretch_[k] * wall_pair_[k];
                Vec4 u_is = wall_stretch_[k] * own;
                if (with_walls) u_is.head<3>() -= wall_velocity_[k].array();
                sum += w[0] * Qx + w[1] * Qy + w[2] * Qz + 2 * c * w[3] * u_is;
            }
        y[at(i)] = u[at(i)] + Vec3(sum.head<3>().matrix());
    });
}

void ViscousOperator::multiply(Span<const Vec3> u, Span<Vec3> y) const {
    load(u, true);
    strain(false);
    divergence(false, u, y);
    parallel_for(size(), [&](Index i) {
        if (!free_[at(i)]) y[at(i)].setZero();
    });
}

void ViscousOperator::force(Span<const Vec3> u, Span<Vec3> y) const {
    load(u, false);
    strain(true);
    divergence(true, u, y);
}

}  // namespace whorl
