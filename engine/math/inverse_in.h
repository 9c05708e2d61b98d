#pragma once
/// Inverses of symmetric 3x3 matrices in 3D and 2D. In 2D only the first two rows and columns are used, and the others are 0.
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

/// Pseudo-inverse of a symmetric positive semi-definite matrix. The weight of the eigenvector with the eigenvalue s is a smooth step of
/// ln(s/s_max), from 0 at s = 0.01 s_max to 1 at s = 0.04 s_max, with the largest eigenvalue s_max. So neighbours in a plane, neighbours on
/// a line, or a single neighbour give no gradient across, and a direction appears or vanishes without a jump.
/// @param dimensions 2: the third row and column are 0, also in the inverse
Mat3d pseudo_inverse(const Mat3d& matrix, int dimensions = 3);

}  // namespace whorl
