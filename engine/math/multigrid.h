#pragma once
/// A V-cycle on an explicit symmetric matrix whose unknowns are in cells of a lattice (Takahashi et al. 2016, Algorithm 3; aggregates and
/// Galerkin operators as Vanek, Mandel and Brezina 1996).
#include <Eigen/Cholesky>

#include "engine/math/sparse_rows.h"

namespace whorl {

using GridCell = Eigen::Vector3i;

/// Numbers the cells in the order in which they are first met.
class CellNumbers {
public:
    explicit CellNumbers(std::size_t expected);
    /// @returns the number of the cell; a cell that is met for the first time gets a new one
    Index number(const GridCell& cell);
    const std::vector<GridCell>& cells() const { return cells_; }
    std::vector<GridCell> take() { return std::move(cells_); }

private:
    void grow();
    std::size_t slot(const GridCell& cell) const;
    std::vector<Index> table_;  ///< number + 1, 0: free. Open addressing; the size is a power of two
    std::vector<GridCell> cells_;
};

struct MultigridOptions {
    Index coarsest = 250;   ///< most unknowns that a dense Cholesky factorisation solves
    int sweeps_before = 1;  ///< number of damped Jacobi sweeps on each level before the correction from the next level, at least 1
    int sweeps_after = 1;   ///< number of sweeps after that correction; equal to sweeps_before for a symmetric cycle, which conjugate
                            ///< gradients need
};

/// Preconditioner x = M^-1 b for the matrix A: one V-cycle. M is symmetric and positive definite for any symmetric positive semi-definite A
/// if the numbers of sweeps before and after are equal.
///
/// A cycle makes damped Jacobi sweeps from zero, adds the correction from the next level, and makes sweeps again. On the next level,
/// 2 x 2 x 2 cells become one, and the matrix is P^T A P with the interpolation P. The coarsest level is solved by Cholesky factorisation.
/// If a connected component of its matrix is singular, as in a closed box, the solve uses b minus its mean over the component. This mean,
/// divided by the mean diagonal of the component, is then added to x. Rows with a zero diagonal give x = 0.
class Multigrid {
public:
    void set_up(SparseRows A, std::vector<GridCell> cells, const MultigridOptions& options);
    void operator()(Span<const Real> b, Span<Real> x) const;
    int levels() const { return static_cast<int>(levels_.size()); }
    std::size_t bytes() const;
    Index size() const { return levels_.empty() ? 0 : levels_.front().A.size(); }

private:
    struct Level {
        SparseRows A;
        Column<Real> smoothing;  ///< w/D: damping factor w of the Jacobi sweeps, divided by the diagonal D of A
        SparseRows P, R;         ///< interpolation from the next level to this one, and its transpose; empty on the coarsest
        mutable Column<Real> b, x, work;
    };
    void cycle(std::size_t level, Span<const Real> b, Span<Real> x) const;
    /// A connected component of the coarsest matrix whose rows add up to 0, as in a closed box.
    struct Component {
        std::vector<Index> members;
        double diagonal = 0;  ///< mean of its diagonal
    };
    static std::vector<Component> closed_components(const Eigen::MatrixXd& A);
    void factor(const SparseRows& A);
    void solve_coarsest(Span<const Real> b, Span<Real> x) const;

    std::vector<Level> levels_;
    int sweeps_before_ = 1, sweeps_after_ = 1;
    Eigen::LLT<Eigen::MatrixXd> coarsest_;
    std::vector<Component> closed_;
};

/// Estimate of the largest eigenvalue of D^-1 A, with the diagonal D of A: 1.1 times the result of the power method, but at most the
/// largest row sum of |D^-1 A|.
Real largest_eigenvalue(const SparseRows& A, Span<const Real> inverse_diagonal);

}  // namespace whorl
