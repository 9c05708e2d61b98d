#pragma once
/// Coarse matrices of rigid motions compared with their definition R^T A R.
#include <algorithm>
#include <cmath>

#include "engine/math/block_cholesky.h"
#include "engine/particles/aggregates.h"

namespace whorl::test {

struct CoarseDifference {
    double largest = 0, difference = 0;  ///< of the entries of R^T A R; difference from the coarse matrix
};

/// @param A called as A(Span<const Vec3> u, Span<Vec3> Au) @param particles number of particles
template <class Operator>
CoarseDifference coarse_difference(const Operator& A, const RigidAggregates& R, const SymmetricBlocks& coarse, std::size_t particles) {
    CoarseDifference found;
    std::vector<Real> motion(6 * coarse.nodes()), column(motion.size());
    std::vector<Vec3> u(particles), Au(particles);
    for (int k = 0; k < 6 * coarse.nodes(); ++k) {
        std::fill(motion.begin(), motion.end(), Real(0));
        motion[k] = 1;
        for (std::size_t i = 0; i < particles; ++i) u[i] = R.motion_of(motion, static_cast<Index>(i));
        A(u, Au);
        R.restrict_to_groups(Au, column);
        for (int row = k / 6; row < coarse.nodes(); ++row) {
            Eigen::Matrix<double, 6, 1> stored = Eigen::Matrix<double, 6, 1>::Zero();
            for (const SymmetricBlocks::Entry& e : coarse.row(row))
                if (e.column == k / 6) stored = e.value.col(k % 6);
            for (int a = 0; a < 6; ++a) {
                const double exact = column[6 * row + a];
                found.largest = std::max(found.largest, std::abs(exact));
                found.difference = std::max(found.difference, std::abs(stored[a] - exact));
            }
        }
    }
    return found;
}

}  // namespace whorl::test
