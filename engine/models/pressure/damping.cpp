#include "engine/models/pressure/damping.h"

#include <cmath>

#include "engine/core/parallel.h"
#include "engine/math/inverse_in.h"

namespace whorl {

void DampUnresolved::operator()(const InteractionContext& context, Read<field::role> role, Update<field::velocity> u) {
    const StepContext& step = context.step;
    const double fall = std::sqrt(static_cast<double>(step.gravity.norm() / step.spacing) + tension_ / static_cast<double>(step.mass));
    const auto c = static_cast<Real>(std::min(0.3, rate_ * static_cast<double>(step.dt) * fall));
    if (!(c > 0)) return;
    const Column<Vec3> change = with_kernel(step.kernel, step.support, [&](const auto& W) {
        return find_changes(W, context.pairs, step, u, find_gradients(W, context.pairs, step, u), c);
    });
    parallel_for(u.size(), [&](Index i) {
        if (role[i] == 0) u[i] += change[i];
    });
}

/// G_i = (sum_j w (u_i - u_j) r^T) (sum_j w r r^T)^-1,   w = V W/r^2
template <class Kernel>
DampUnresolved::Stretching DampUnresolved::find_gradients(const Kernel& W, const FluidPairs& pairs, const StepContext& step,
                                                          Update<field::velocity> u) {
    Stretching stretching;
    stretching.along.resize(u.size()), stretching.across.resize(u.size());
    parallel_for(u.size(), [&](Index i) {
        Mat3 moment = Mat3::Zero(), product = Mat3::Zero();
        pairs.groups_of(i, [&](const Pairs::Group& group) {
            alignas(64) Real v[3][most], w[most];
            group.gather(u.values.data(), v);
            for (Index l = 0; l < group.padded(); ++l)
                w[l] = W.value(group.distance[l]) * step.volume / std::max(group.distance[l] * group.distance[l], min_positive);
            for (int a = 0; a < 3; ++a)
                for (int b = 0; b < 3; ++b) {
                    Real r_r = 0, u_r = 0;
                    for (Index l = 0; l < group.padded(); ++l) {
                        const Real weighted = w[l] * group.r[b][l];
                        u_r += (u[i][a] - v[a][l]) * weighted;
                        if (a <= b) r_r += group.r[a][l] * weighted;
                    }
                    product(a, b) += u_r;
                    if (a <= b) moment(a, b) += r_r;
                }
        });
        for (int a = 1; a < 3; ++a)
            for (int b = 0; b < a; ++b) moment(a, b) = moment(b, a);
        const int dimensions = step.dimensions();
        const Real size = moment.trace() / static_cast<Real>(dimensions);
        const bool spans = determinant_in(dimensions, moment) > Real(0.05) * power_of(size, dimensions);
        const Mat3 G = spans ? Mat3(product * inverse_in(dimensions, moment)) : Mat3(Mat3::Zero());
        // The pull along a pair needs only (G r).r of both particles: r_a r_b (G_ab + G_ba)/2, six numbers per particle.
        stretching.along[i] = G.diagonal();
        stretching.across[i] = Vec3(G(0, 1) + G(1, 0), G(1, 2) + G(2, 1), G(2, 0) + G(0, 2));
    });
    return stretching;
}

/// D c sum_j V W_ij (e_ij.r_ij) r_ij/|r_ij|^2
template <class Kernel>
Column<Vec3> DampUnresolved::find_changes(const Kernel& W, const FluidPairs& pairs, const StepContext& step, Update<field::velocity> u,
                                          const Stretching& stretching, Real c) {
    Column<Vec3> change(static_cast<std::size_t>(u.size()));
    parallel_for(u.size(), [&](Index i) {
        Vec3 sum = Vec3::Zero();
        pairs.groups_of(i, [&](const Pairs::Group& group) {
            alignas(64) Real v[3][most], along[3][most], across[3][most], pull[most];
            group.gather(u.values.data(), v);
            group.gather(stretching.along.data(), along);
            group.gather(stretching.across.data(), across);
            const Vec3 &d = stretching.along[i], &o = stretching.across[i];
            for (Index l = 0; l < group.padded(); ++l) {
                const Real x = group.r[0][l], y = group.r[1][l], z = group.r[2][l], r = group.distance[l];
                const Real stretched = (d[0] + along[0][l]) * x * x + (d[1] + along[1][l]) * y * y + (d[2] + along[2][l]) * z * z +
                                       (o[0] + across[0][l]) * x * y + (o[1] + across[1][l]) * y * z + (o[2] + across[2][l]) * z * x;
                const Real e_r = (v[0][l] - u[i][0]) * x + (v[1][l] - u[i][1]) * y + (v[2][l] - u[i][2]) * z + stretched / 2;
                pull[l] = W.value(r) * step.volume * e_r / std::max(r * r, min_positive);
            }
            for (int a = 0; a < 3; ++a) {
                Real part = 0;
                for (Index l = 0; l < group.padded(); ++l) part += pull[l] * group.r[a][l];
                sum[a] += part;
            }
        });
        change[i] = static_cast<Real>(W.dimensions) * c * sum;
    });
    return change;
}

}  // namespace whorl
