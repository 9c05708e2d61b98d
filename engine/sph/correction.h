#pragma once
/// First-order correction of kernel gradients (Randles and Libersky 1996).
#include "engine/particles/pairs.h"
#include "engine/particles/step_context.h"

namespace whorl {

/// Pseudo-inverse of a symmetric positive semi-definite matrix. A direction counts as resolved by a smooth step of ln(s_a/s_max) from ln
/// 0.01 to ln 0.04: a neighbourhood that is a plane, a line or a single neighbour gets no gradient across, and gains or loses a direction
/// without a jump.
/// @param dimensions 2: the third row and column are 0, and so are those of the inverse
Mat3d pseudo_inverse(const Mat3d& matrix, int dimensions = 3);

/// L_i = (sum_j V_j grad W_ij (x_j - x_i)^T)^+        L_i times the difference gradient of operators.h is exact for linear fields wherever
/// the neighbours span all directions, at free surfaces too.
/// @param V volumes [m^3] @param L one matrix a particle, no unit, written
void sum_correction(const Pairs& pairs, KernelForm kernel, Real support, Span<const Real> V, Span<Mat3> L);

}  // namespace whorl
