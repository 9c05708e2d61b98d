#pragma once
/// Scalar, vector and index types.
#include <Eigen/Geometry>
#include <cstdint>
#include <limits>
#include <span>

namespace whorl {

#ifdef WHORL_DOUBLE
using Real = double;
#else
using Real = float;
#endif

/// Index of a particle or array element.
using Index = std::int32_t;
using Vec3 = Eigen::Matrix<Real, 3, 1>;
using Mat3 = Eigen::Matrix<Real, 3, 3>;
using Vec3f = Eigen::Vector3f;
using Vec3d = Eigen::Vector3d;
using Mat3f = Eigen::Matrix3f;
using Mat3d = Eigen::Matrix3d;

/// Lower bound for divisors.
inline constexpr Real min_positive = std::numeric_limits<Real>::min();

template <class T>
using Span = std::span<T>;

}  // namespace whorl
