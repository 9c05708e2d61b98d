#pragma once
#include <Eigen/Sparse>

#include "engine/models/coupled/strain.h"

namespace whorl {

/// Ac = R^T (1 + K) R for the rigid motions u = v + omega x arm of aggregates: six unknowns each (v, omega), lower triangle.
/// @param of aggregate of each particle, -1: none, its velocity is held @param arm from the aggregate's centre, in spacings
Eigen::SparseMatrix<double> coarse_matrix(const StrainForm& form, Span<const std::int32_t> of, Span<const Vec3> arm, int aggregates);

}  // namespace whorl
