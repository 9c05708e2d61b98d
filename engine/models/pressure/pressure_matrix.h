#pragma once
/// The symmetric matrix of a pressure equation over particles, and its preconditioners.
#include <functional>
#include <vector>

#include "engine/core/column.h"
#include "engine/math/solve.h"
#include "engine/particles/pairs.h"

namespace whorl {

/// z = M r, with M approximating A^-1, symmetric and positive definite on the unknowns; z = 0 elsewhere.
struct PressurePreconditioner {
    std::function<void(Span<const Real> r, Span<Real> z)> apply;
    int levels = 1;
    std::size_t bytes = 0;  ///< memory of the preconditioner

    void operator()(Span<const Real> r, Span<Real> z) const { apply(r, z); }
};

/// Rows of the pressure equation over the unknown (Poisson) particles, made symmetric by the factor V_i:
///   (A p)_i = sum_j c_ij (p_i - p_j) + d_i p_i,  c_ij = V_i a_ij = c_ji,  d_i = V_i (alpha_i + sum over Dirichlet neighbours a_ij).
/// docs/physics.md 3 has the coefficients a_ij, and alpha_i, the effect of a uniform pressure on row i. Dirichlet neighbours have a known
/// pressure. Particles that are not unknown have an empty row and a unit diagonal.
struct PressureMatrix {
    const FluidPairs* pairs = nullptr;  ///< must outlive the use of the matrix
    Column<Real> c;                     ///< coefficients of the pairs [m]; 0 if one of the two is not unknown
    Column<Real> diagonal;              ///< sum_j c_ij + d_i [m]
    Column<Real> pin;                   ///< d_i [m]
    std::vector<char> unknown;
    Real spacing = 0;

    Index size() const { return static_cast<Index>(diagonal.size()); }
    /// Makes rows with a unit diagonal; the coefficients of unknowns are not set, the others are 0. `unknown` must be set before.
    /// @param d spacing [m]
    void lay_out(const FluidPairs& of, Real d);
    void multiply(Span<const Real> p, Span<Real> Ap) const;
};

/// Called once per step with the matrix.
using PressurePreconditionerSetup = std::function<PressurePreconditioner(const PressureMatrix&)>;
/// z = r/diagonal.
PressurePreconditioner jacobi(const PressureMatrix& matrix);
/// z = r.
PressurePreconditioner poisson_unpreconditioned(const PressureMatrix& matrix);

/// A connected component of unknowns that touches no surface particle.
struct ClosedRegion {
    std::vector<Index> members;
    bool singular = false;  ///< true: p is determined only up to a constant, or nearly so
};

struct ClosedRegions {
    std::vector<ClosedRegion> all;
    /// @param touches_surface by particle @param tied a region is singular if its pins are less than this fraction of its diagonals
    void find(const PressureMatrix& matrix, Span<const char> touches_surface, double tied);
    /// Sets the pins d_i of singular regions to 0. In a full box they consist of alpha_i alone, which is small and differs from 0 only
    /// because neighbours are uneven. If kept, they would turn the mean of the right-hand side into a huge uniform pressure.
    void take_pins_away(PressureMatrix& matrix) const;
    /// Subtracts the mean of b over each singular region, so that the equation is solvable there.
    void subtract_means(Span<Real> b) const;
};

}  // namespace whorl
