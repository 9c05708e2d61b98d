#pragma once
/// Inverses of the moments of neighbourhoods.
#include "engine/core/types.h"

namespace whorl {

/// Pseudo-inverse of a symmetric positive semi-definite matrix. A direction counts as resolved by a smooth step of ln(s_a/s_max) from ln
/// 0.01 to ln 0.04: a neighbourhood that is a plane, a line or a single neighbour gets no gradient across, and gains or loses a direction
/// without a jump.
/// @param dimensions 2: the third row and column are 0, and so are those of the inverse
Mat3d pseudo_inverse(const Mat3d& matrix, int dimensions = 3);

}  // namespace whorl
