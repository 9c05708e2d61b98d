#pragma once
/// The nearest point of a triangle.
#include <Eigen/Core>

namespace whorl {

template <class Scalar>
struct NearestOnTriangle {
    Eigen::Matrix<Scalar, 3, 1> point;
    int feature;  ///< location of the point: 0 to 2 corner a, b or c; 3 to 5 the edge opposite to corner a, b or c; 6 the face
};

/// The point of triangle abc nearest to p (Ericson 2005, "Real-time collision detection", 5.1.5).
template <class Scalar>
NearestOnTriangle<Scalar> nearest_on_triangle(const Eigen::Matrix<Scalar, 3, 1>& p, const Eigen::Matrix<Scalar, 3, 1>& a,
                                              const Eigen::Matrix<Scalar, 3, 1>& b, const Eigen::Matrix<Scalar, 3, 1>& c) {
    const Eigen::Matrix<Scalar, 3, 1> ab = b - a, ac = c - a, ap = p - a;
    const Scalar d1 = ab.dot(ap), d2 = ac.dot(ap);
    if (d1 <= 0 && d2 <= 0) return {a, 0};
    const Eigen::Matrix<Scalar, 3, 1> bp = p - b;
    const Scalar d3 = ab.dot(bp), d4 = ac.dot(bp);
    if (d3 >= 0 && d4 <= d3) return {b, 1};
    const Scalar vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return {a + d1 / (d1 - d3) * ab, 5};
    const Eigen::Matrix<Scalar, 3, 1> cp = p - c;
    const Scalar d5 = ab.dot(cp), d6 = ac.dot(cp);
    if (d6 >= 0 && d5 <= d6) return {c, 2};
    const Scalar vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return {a + d2 / (d2 - d6) * ac, 4};
    const Scalar va = d3 * d6 - d5 * d4;
    if (va <= 0 && d4 >= d3 && d5 >= d6) return {b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b), 3};
    const Scalar sum = va + vb + vc;
    if (!(sum > 0)) return {a, 0};  // a degenerate triangle: its area is zero
    return {a + vb / sum * ab + vc / sum * ac, 6};
}

}  // namespace whorl
