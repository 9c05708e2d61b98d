#pragma once
/// The symmetric matrix of a pressure equation over particles, and what its preconditioners are.
#include <vector>

#include "engine/core/column.h"
#include "engine/math/solve.h"
#include "engine/models/pressure/preconditioner.h"

namespace whorl {

/// Rows of the pressure equation over the unknown (Poisson) particles, made symmetric by the factor V_i:
///   (A p)_i = sum_j c_ij (p_i - p_j) + d_i p_i,  c_ij = V_i a_ij = c_ji,  d_i = V_i (alpha_i + sum over Dirichlet neighbours a_ij).
/// Entries of particles that are not unknown have an empty row and a unit diagonal.
struct PressureMatrix {
    std::vector<std::size_t> first;  ///< n + 1
    Column<Index> other;             ///< unknown neighbours
    Column<Real> c;                  ///< their coefficients [m]
    Column<Real> diagonal;           ///< sum_j c_ij + d_i [m]
    Column<Real> pin;                ///< d_i [m]
    std::vector<char> unknown;
    Span<const Vec3> x;  ///< positions
    Real spacing = 0;

    Index size() const { return static_cast<Index>(diagonal.size()); }
    void multiply(Span<const Real> p, Span<Real> Ap) const;
};

/// Set up once a step from the matrix.
using PressurePreconditionerSetup = std::function<PressurePreconditioner(const PressureMatrix&)>;
/// z = r/diagonal.
PressurePreconditioner jacobi(const PressureMatrix& matrix);
/// z = r.
PressurePreconditioner poisson_unpreconditioned(const PressureMatrix& matrix);

}  // namespace whorl
