#pragma once
/// Discrete operators at one particle, as sums over its row of pairs. r_ij = x_i - x_j, grad W_ij with respect to x_i, V volumes [m^3].
/// Each takes the kernel as a type (with_kernel), so that a loop over particles holds no branch on its kind.
#include <Eigen/Geometry>

#include "engine/particles/pairs.h"

namespace whorl {

/// grad W_ij = W'(|r|) r / |r|; zero where the two stand at the same place.
template <class Kernel>
Vec3 kernel_gradient(const Kernel& W, const Vec3& r, Real distance) {
    return distance > 0 ? Vec3((W.derivative(distance) / distance) * r) : Vec3(Vec3::Zero());
}

/// sum_j W_ij over the row of i, W_ii not included [m^-D].
template <class Kernel>
Real kernel_sum(const Pairs& pairs, Index i, const Kernel& W) {
    Real sum = 0;
    pairs.of(i, [&](Index, const Vec3&, Real distance) { sum += W.value(distance); });
    return sum;
}

/// (grad a)_i = sum_j V_j (a_j - a_i) grad W_ij        Exact for constants; times correction() of i, exact for linear fields.
template <class Kernel>
Vec3 gradient(const Pairs& pairs, Index i, const Kernel& W, Span<const Real> V, Span<const Real> a) {
    Vec3 sum = Vec3::Zero();
    const Real ai = a[i];
    pairs.of(i, [&](Index j, const Vec3& r, Real distance) { sum += (V[j] * (a[j] - ai)) * kernel_gradient(W, r, distance); });
    return sum;
}

/// (grad u)_i = sum_j V_j (u_j - u_i) (grad W_ij)^T        Row: component of u; column: direction of the derivative.
template <class Kernel>
Mat3 gradient(const Pairs& pairs, Index i, const Kernel& W, Span<const Real> V, Span<const Vec3> u) {
    Mat3 sum = Mat3::Zero();
    const Vec3 ui = u[i];
    pairs.of(i, [&](Index j, const Vec3& r, Real distance) { sum += V[j] * (u[j] - ui) * kernel_gradient(W, r, distance).transpose(); });
    return sum;
}

/// (div u)_i = sum_j V_j (u_j - u_i) . grad W_ij
template <class Kernel>
Real divergence(const Pairs& pairs, Index i, const Kernel& W, Span<const Real> V, Span<const Vec3> u) {
    Real sum = 0;
    const Vec3 ui = u[i];
    pairs.of(i, [&](Index j, const Vec3& r, Real distance) { sum += V[j] * (u[j] - ui).dot(kernel_gradient(W, r, distance)); });
    return sum;
}

/// (curl u)_i = -sum_j V_j (u_j - u_i) x grad W_ij
template <class Kernel>
Vec3 curl(const Pairs& pairs, Index i, const Kernel& W, Span<const Real> V, Span<const Vec3> u) {
    Vec3 sum = Vec3::Zero();
    const Vec3 ui = u[i];
    pairs.of(i, [&](Index j, const Vec3& r, Real distance) { sum -= V[j] * (u[j] - ui).cross(kernel_gradient(W, r, distance)); });
    return sum;
}

/// (Lap u)_i = 2 sum_j V_j (u_i - u_j) (r_ij . grad W_ij) / (|r_ij|^2 + 0.01 h^2), h = R/2        Brookshaw (1985), Morris et al. (1997).
template <class Kernel, class T>
T laplacian(const Pairs& pairs, Index i, const Kernel& W, Span<const Real> V, Span<const T> u) {
    T sum = T(u[i] - u[i]);
    const T ui = u[i];
    const Real softening = Real(0.01 * 0.25) * W.R * W.R;
    pairs.of(i, [&](Index j, const Vec3&, Real distance) {
        sum += (2 * V[j] * distance * W.derivative(distance) / (distance * distance + softening)) * (ui - u[j]);
    });
    return sum;
}

/// (Lap u)_i = 2 (D + 2) sum_j V_j (u_ij . r_ij) / (|r_ij|^2 + 0.01 h^2) grad W_ij        Monaghan (1992): along the pair, keeps angular
/// momentum; for fields with a divergence it converges to Lap u + 2 grad div u.
template <class Kernel>
Vec3 pairwise_laplacian(const Pairs& pairs, Index i, const Kernel& W, Span<const Real> V, Span<const Vec3> u) {
    Vec3 sum = Vec3::Zero();
    const Vec3 ui = u[i];
    const Real softening = Real(0.01 * 0.25) * W.R * W.R, factor = 2 * static_cast<Real>(W.dimensions + 2);
    pairs.of(i, [&](Index j, const Vec3& r, Real distance) {
        sum += (factor * V[j] * (ui - u[j]).dot(r) / (distance * distance + softening)) * kernel_gradient(W, r, distance);
    });
    return sum;
}

}  // namespace whorl
