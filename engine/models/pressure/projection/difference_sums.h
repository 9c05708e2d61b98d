#pragma once
/// Sums of differences between a particle and its neighbours: gradients and Laplacians.
#include <array>
#include <cstddef>
#include <type_traits>

#include "engine/models/pressure/projection/projection_system.h"

namespace whorl {

/// sum_j V (f_j - f_i) W'/r r^T over the fluid. Multiplied by L_i it is the gradient; rows are the components of f.
template <class Kernel>
Mat3 difference_sum(const Kernel& W, const FluidPairs& pairs, Index i, Real volume, const Vec3* f) {
    Real sum[9] = {0, 0, 0, 0, 0, 0, 0, 0, 0};
    const Vec3 own = f[i];
    pairs.groups_of(i, [&](const Pairs::Group& group) {
        Real other[3][Pairs::Group::most], part[9] = {0, 0, 0, 0, 0, 0, 0, 0, 0};
        group.gather(f, other);
        for (Index l = 0; l < group.padded(); ++l) {
            const Real F = W.slope(group.distance[l]);
            const Real x = F * group.r[0][l], y = F * group.r[1][l], z = F * group.r[2][l];
            const Real a = other[0][l] - own[0], b = other[1][l] - own[1], c = other[2][l] - own[2];
            part[0] += a * x, part[1] += a * y, part[2] += a * z;
            part[3] += b * x, part[4] += b * y, part[5] += b * z;
            part[6] += c * x, part[7] += c * y, part[8] += c * z;
        }
        for (int k = 0; k < 9; ++k) sum[k] += part[k];
    });
    Mat3 S;
    S << sum[0], sum[1], sum[2], sum[3], sum[4], sum[5], sum[6], sum[7], sum[8];
    return volume * S;
}

/// Scalar version.
template <class Kernel>
Vec3 difference_sum(const Kernel& W, const FluidPairs& pairs, Index i, Real volume, const Real* f) {
    Vec3 sum = Vec3::Zero();
    const Real own = f[i];
    pairs.groups_of(i, [&](const Pairs::Group& group) {
        Real other[Pairs::Group::most], part[3] = {0, 0, 0};
        group.gather(f, other);
        for (Index l = 0; l < group.padded(); ++l) {
            const Real F = W.slope(group.distance[l]) * (other[l] - own);
            for (int a = 0; a < 3; ++a) part[a] += F * group.r[a][l];
        }
        sum += Vec3(part[0], part[1], part[2]);
    });
    return volume * sum;
}

/// Sums over the neighbours of one particle, of a vector f.
struct DifferenceSums {
    Vec3 laplacian = Vec3::Zero();  ///< sum V W'/r (f_i - f_j)
    Mat3 gradient = Mat3::Zero();   ///< sum V (f_j - f_i) W'/r r^T
    Vec3 smooth = Vec3::Zero();     ///< sum V W (f_j - f_i), with the kernel `smoothing` as W
};

/// Sums of several fields f.
/// @param smoothing a second kernel; nullptr: `smooth` stays 0
template <std::size_t fields, class Kernel, class Smoothing>
std::array<DifferenceSums, fields> difference_sums(const Kernel& W, const FluidPairs& pairs, Index i, Real volume,
                                                   const std::array<const Vec3*, fields>& f, const Smoothing& smoothing) {
    constexpr bool smooths = !std::is_null_pointer_v<Smoothing>;
    std::array<DifferenceSums, fields> all;
    const auto add = [&](const Pairs::Group& group, const Vec3* field, DifferenceSums& sums) {
        const Vec3 own = field[i];
        Real other[3][Pairs::Group::most], lap[3] = {0, 0, 0}, smooth[3] = {0, 0, 0}, S[9] = {0, 0, 0, 0, 0, 0, 0, 0, 0};
        group.gather(field, other);
        for (Index l = 0; l < group.padded(); ++l) {
            const Real F = W.slope(group.distance[l]);
            const Real x = group.r[0][l], y = group.r[1][l], z = group.r[2][l];
            const Real a = own[0] - other[0][l], b = own[1] - other[1][l], c = own[2] - other[2][l];
            lap[0] += F * a, lap[1] += F * b, lap[2] += F * c;
            if constexpr (smooths) {
                const Real near = smoothing.value(group.distance[l]);
                smooth[0] -= near * a, smooth[1] -= near * b, smooth[2] -= near * c;
            }
            const Real p = F * a, q = F * b, t = F * c;
            S[0] -= p * x, S[1] -= p * y, S[2] -= p * z;
            S[3] -= q * x, S[4] -= q * y, S[5] -= q * z;
            S[6] -= t * x, S[7] -= t * y, S[8] -= t * z;
        }
        sums.laplacian += volume * Vec3(lap[0], lap[1], lap[2]);
        sums.smooth += volume * Vec3(smooth[0], smooth[1], smooth[2]);
        for (int k = 0; k < 9; ++k) sums.gradient(k / 3, k % 3) += volume * S[k];
    };
    pairs.groups_of(i, [&](const Pairs::Group& group) {
        for (std::size_t k = 0; k < fields; ++k) add(group, f[k], all[k]);
    });
    return all;
}

/// Sums for Lap u at a particle near flat walls along which the fluid slips freely, over the fluid and its images behind these walls.
/// Without the images, the sums over one side contain a third to two thirds of Lap u.
struct MirroredSums {
    Vec3 laplacian = Vec3::Zero();  ///< sum_j V weight_j W'/r (u_i - u_j)
    Mat3 gradient = Mat3::Zero();   ///< gradient of u, exact for linear fields
    Real trace = 0;                 ///< of -sum_j V W'/r r r^T
    Vec3 imbalance = Vec3::Zero();  ///< sum_j V W'/r r [1/m]
};
/// @param of_images velocities of the images @param weight j -> factor of a neighbour in `laplacian`
template <class Kernel, class Weight>
MirroredSums mirrored_sums(const Kernel& W, const ProjectionSystem& s, const InteractionContext& context, Index i, Span<const Vec3> u,
                           Span<const Vec3> of_images, const Weight& weight) {
    Real lap[3]{}, S[9]{}, M[6]{}, plain[3]{};
    const Vec3 own = u[i];
    s.mirrors.groups_of(context.pairs, i, [&]<bool image>(const Pairs::Group& group, const Real* shares) {
        Real other[3][Pairs::Group::most], F[Pairs::Group::most], part[Pairs::Group::most];
        group.gather(image ? of_images.data() : u.data(), other);
        for (Index l = 0; l < group.padded(); ++l) {
            const Index j = group.other[l];
            part[l] = weight(image ? s.mirrors.owner(j) : j);
            F[l] = image ? (s.slides[j] ? shares[l] : 0) : 1;
        }
        Real lap_part[3]{}, S_part[9]{}, M_part[6]{}, plain_part[3]{};
        for (Index l = 0; l < group.padded(); ++l) {
            const Real f = F[l] * W.slope(group.distance[l]), x = group.r[0][l], y = group.r[1][l], z = group.r[2][l];
            const Real p = f * (own[0] - other[0][l]), q = f * (own[1] - other[1][l]), t = f * (own[2] - other[2][l]);
            lap_part[0] += part[l] * p, lap_part[1] += part[l] * q, lap_part[2] += part[l] * t;
            S_part[0] -= p * x, S_part[1] -= p * y, S_part[2] -= p * z;
            S_part[3] -= q * x, S_part[4] -= q * y, S_part[5] -= q * z;
            S_part[6] -= t * x, S_part[7] -= t * y, S_part[8] -= t * z;
            M_part[0] -= f * x * x, M_part[1] -= f * x * y, M_part[2] -= f * x * z;
            M_part[3] -= f * y * y, M_part[4] -= f * y * z, M_part[5] -= f * z * z;
            plain_part[0] += f * x, plain_part[1] += f * y, plain_part[2] += f * z;
        }
        for (int k = 0; k < 9; ++k) S[k] += S_part[k];
        for (int k = 0; k < 6; ++k) M[k] += M_part[k];
        for (int k = 0; k < 3; ++k) lap[k] += lap_part[k], plain[k] += plain_part[k];
    });
    const Real V = context.step.volume;
    MirroredSums all{V * Vec3(lap[0], lap[1], lap[2]), Mat3::Zero(), 0, V * Vec3(plain[0], plain[1], plain[2])};
    all.gradient << S[0], S[1], S[2], S[3], S[4], S[5], S[6], S[7], S[8];
    all.gradient *= V;
    Mat3d moment;
    moment << M[0], M[1], M[2], M[1], M[3], M[4], M[2], M[4], M[5];
    moment *= V;
    all.gradient = all.gradient * pseudo_inverse(moment, context.step.dimensions()).template cast<Real>();
    all.trace = static_cast<Real>(moment.trace());
    return all;
}
/// Velocities of the images behind walls.
inline Span<const Vec3> image_velocities(const ProjectionSystem& s, const InteractionContext& context, Span<const Vec3> u) {
    return s.mirrors.velocities(u, [&](Index solid) { return context.solids.all[solid].pose.velocity; });
}

/// Change of a vector f from x_i to x_i + move: gradient times move, plus |move|^2/(2 D) times the Laplacian. The second term is for the
/// curvature of f; without it crests would grow with every move.
/// @param sums of the kernel W
template <class Kernel>
Vec3 carried(const Kernel& W, const LinearSums& sums, const FluidPairs& pairs, Index i, Real volume, const Vec3* f, const Vec3& move) {
    const DifferenceSums of_f = difference_sums<1>(W, pairs, i, volume, {f}, nullptr)[0];
    const Mat3 G = of_f.gradient * sums.correction[i];
    return G * move + move.squaredNorm() / std::max(sums.trace[i], Real(0.1)) * (of_f.laplacian - G * sums.imbalance[i]);
}

}  // namespace whorl
