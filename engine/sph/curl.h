#pragma once
/// The three discrete curls (docs/physics.md 8), as sums over a row of pairs. r_ij = x_i - x_j, m the mass of a particle [kg].
#include "engine/math/kernel.h"

namespace whorl {

///   symmetric:               -rho_i sum_j m (u_i/rho_i^2 + u_j/rho_j^2) x grad W_ij    times m/rho_i, antisymmetric in the pair
///   difference:              sum_j m/rho_j (u_i - u_j) x grad W_ij                     exact for constant u
///   difference_own_density:  1/rho_i sum_j m (u_i - u_j) x grad W_ij                   adjoint of the first: sum V v.curl u = sum V
///                                                                                      u.curl v
enum class CurlForm { symmetric, difference, difference_own_density };

/// All three forms are sum_j m (P u_i - Q u_j) x grad W_ij with P = p + p_b b_j, Q = q_b b_j + q_bb b_j^2 + q and b = 1/rho, so one loop
/// computes any of them.
struct CurlWeights {
    Real p, p_b, q, q_b, q_bb;
    Real own(Real b_j) const { return p + p_b * b_j; }
    Real other(Real b_j) const { return q + (q_b + q_bb * b_j) * b_j; }
};
/// @param b_i 1/rho_i [m^3/kg]
inline CurlWeights curl_weights(CurlForm form, Real b_i) {
    switch (form) {
        case CurlForm::symmetric: return {-b_i, 0, 0, 0, 1 / b_i};
        case CurlForm::difference: return {0, 1, 0, 1, 0};
        default: return {b_i, 0, b_i, 0, 0};
    }
}

/// Largest eigenvalue k [1/m] of the discrete curl over waves on a lattice, along an edge and along its diagonals. It bounds the step of
/// an explicit exchange.
double largest_curl(KernelForm kernel, Real support, Real spacing);

}  // namespace whorl
