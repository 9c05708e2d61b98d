#pragma once
/// Symmetric matrices of directions, in space and in the plane z = 0: there only the first two rows and columns count, and the rest is 0.
#include <Eigen/LU>

#include "engine/core/types.h"

namespace whorl {

template <class Matrix>
Matrix inverse_in(int dimensions, const Matrix& m) {
    if (dimensions == 3) return m.inverse();
    Matrix inverse = Matrix::Zero();
    inverse.template topLeftCorner<2, 2>() = m.template topLeftCorner<2, 2>().inverse();
    return inverse;
}

template <class Matrix>
typename Matrix::Scalar determinant_in(int dimensions, const Matrix& m) {
    return dimensions == 3 ? m.determinant() : m(0, 0) * m(1, 1) - m(0, 1) * m(1, 0);
}

/// Pseudo-inverse of a symmetric positive semi-definite matrix. A direction counts as resolved by a smooth step of ln(s_a/s_max) from ln
/// 0.01 to ln 0.04: a neighbourhood that is a plane, a line or a single neighbour gets no gradient across, and gains or loses a direction
/// without a jump.
/// @param dimensions 2: the third row and column are 0, and so are those of the inverse
Mat3d pseudo_inverse(const Mat3d& matrix, int dimensions = 3);

}  // namespace whorl
