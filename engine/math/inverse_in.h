#pragma once
/// Symmetric matrices of directions, in space and in the plane z = 0: there only the first two rows and columns count, and the rest is 0.
#include <Eigen/LU>

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

}  // namespace whorl
