#pragma once
/// Inverses of symmetric 3x3 matrices in 3D and in 2D, where only the first two rows and columns are used and the others are 0.
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

/// Pseudo-inverse of a symmetric positive semi-definite matrix. The weight of an eigenvector rises by a smooth step of ln(s_a/s_max) from
/// 0 at ln 0.01 to 1 at ln 0.04. So neighbours in a plane, on a line or a single neighbour give no gradient across, and a direction
/// appears or vanishes without a jump.
/// @param dimensions 2: the third row and column are 0, also in the inverse
Mat3d pseudo_inverse(const Mat3d& matrix, int dimensions = 3);

}  // namespace whorl
