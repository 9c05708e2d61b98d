#include "engine/math/multigrid.h"

#include <cmath>

#include "engine/core/parallel.h"
#include "engine/math/conjugate_gradients.h"

namespace whorl {
namespace {

Column<Real> inverse_diagonal(const SparseRows& A) {
    Column<Real> inverse(A.size(), 0);
    parallel_for(A.size(), [&](Index i) {
        for (std::size_t k = A.first[i]; k < A.first[i + 1]; ++k)
            if (A.column[k] == i && A.value[k] > min_positive) inverse[i] = 1 / A.value[k];
    });
    return inverse;
}

/// Smoothed interpolation: (1 - w D^-1 A) applied to the vectors that are 1 on a group and 0 elsewhere. @param smoothing w/D
SparseRows interpolation(const SparseRows& A, Span<const Real> smoothing, const std::vector<Index>& group_of, Index groups) {
    SparseRows P;
    P.columns = groups;
    for (std::size_t i = 0; i < group_of.size(); ++i) {
        P.first.push_back(i + 1);
        P.column.push_back(group_of[i]);
        P.value.push_back(1);
    }
    SparseRows S = A;
    parallel_for(S.size(), [&](Index i) {
        for (std::size_t k = S.first[i]; k < S.first[i + 1]; ++k)
            S.value[k] = (S.column[k] == i ? Real(1) : Real(0)) - smoothing[i] * S.value[k];
    });
    return product(S, P);
}

}  // namespace

CellNumbers::CellNumbers(std::size_t expected) {
    std::size_t size = 64;
    while (size < 2 * expected) size *= 2;
    table_.assign(size, 0);
}

std::size_t CellNumbers::slot(const GridCell& cell) const {
    std::uint64_t h = 0;
    for (int a = 0; a < 3; ++a) h = (h ^ static_cast<std::uint32_t>(cell[a])) * 0x9e3779b97f4a7c15u;
    std::size_t s = static_cast<std::size_t>(h >> 20) & (table_.size() - 1);
    while (table_[s] != 0 && cells_[table_[s] - 1] != cell) s = (s + 1) & (table_.size() - 1);
    return s;
}

Index CellNumbers::number(const GridCell& cell) {
    const std::size_t s = slot(cell);
    if (table_[s] != 0) return table_[s] - 1;
    cells_.push_back(cell);
    table_[s] = static_cast<Index>(cells_.size());
    if (2 * cells_.size() > table_.size()) grow();
    return static_cast<Index>(cells_.size()) - 1;
}

void CellNumbers::grow() {
    table_.assign(2 * table_.size(), 0);
    for (std::size_t k = 0; k < cells_.size(); ++k) table_[slot(cells_[k])] = static_cast<Index>(k) + 1;
}

Real largest_eigenvalue(const SparseRows& A, Span<const Real> inverse) {
    const Real bound = static_cast<Real>(parallel_max(A.size(), 0, [&](Index i) {
        Real sum = 0;
        for (std::size_t k = A.first[i]; k < A.first[i + 1]; ++k) sum += std::abs(A.value[k]);
        return sum * inverse[i];
    }));
    // A start vector without symmetries.
    Column<Real> x(A.size()), y(A.size());
    parallel_for(A.size(), [&](Index i) { x[i] = static_cast<Real>(std::sin(12.9898 * (i + 1))); });
    double estimate = 0;
    for (int k = 0; k < 10; ++k) {
        A.multiply(x, y);
        parallel_for(A.size(), [&](Index i) { y[i] *= inverse[i]; });
        const double before = std::sqrt(dot<Real>(x, x)), after = std::sqrt(dot<Real>(y, y));
        if (!(before > 0 && after > 0)) break;
        estimate = after / before;
        parallel_for(A.size(), [&](Index i) { x[i] = static_cast<Real>(y[i] / after); });
    }
    return std::max(min_positive, std::min(bound, static_cast<Real>(1.1 * estimate)));
}

void Multigrid::set_up(SparseRows A, std::vector<GridCell> cells, const MultigridOptions& options) {
    levels_.clear();
    sweeps_before_ = options.sweeps_before, sweeps_after_ = options.sweeps_after;
    for (;;) {
        const Index n = A.size();
        Level& level = levels_.emplace_back();
        for (Column<Real>* column : {&level.b, &level.x, &level.work}) column->assign(n, 0);
        if (n <= options.coarsest) {
            factor(A);
            level.A = std::move(A);
            return;
        }
        level.smoothing = inverse_diagonal(A);
        // With w = 4/3 divided by the largest eigenvalue, the smoothed interpolation is the best of its degree. The cycle is symmetric and
        // positive definite up to w = 2 divided by the largest eigenvalue, so the estimate of that eigenvalue may be a third too small.
        const Real w = Real(4.0 / 3) / largest_eigenvalue(A, level.smoothing);
        for (Real& one : level.smoothing) one *= w;

        CellNumbers numbers(static_cast<std::size_t>(n) / 4);
        std::vector<Index> group_of(n);
        for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i)
            group_of[i] = numbers.number(GridCell(cells[i][0] >> 1, cells[i][1] >> 1, cells[i][2] >> 1));
        level.P = interpolation(A, level.smoothing, group_of, static_cast<Index>(numbers.cells().size()));
        level.R = transposed(level.P);
        level.A = std::move(A);
        A = product(level.R, product(level.A, level.P));
        cells = numbers.take();
    }
}

void Multigrid::factor(const SparseRows& A) {
    Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(A.size(), A.size());
    for (Index i = 0; i < A.size(); ++i)
        for (std::size_t k = A.first[i]; k < A.first[i + 1]; ++k) dense(i, A.column[k]) = static_cast<double>(A.value[k]);
    dense = (dense + dense.transpose()).eval() / 2;
    for (Index i = 0; i < A.size(); ++i)
        if (!(dense(i, i) > static_cast<double>(min_positive))) dense(i, i) = 1;
    coarsest_.compute(dense);
    // left(): smallest pivot, relative to the diagonal element of its row. If A is singular, the pivot is only round-off, and its inverse
    // would be noise.
    constexpr double round_off = 1e-3;
    const auto left = [&] { return (coarsest_.matrixLLT().diagonal().array().square() / dense.diagonal().array()).minCoeff(); };
    if (coarsest_.info() == Eigen::Success && left() > round_off) return;
    // The matrix is singular, as in a closed box. Raising the diagonal makes the response to a constant b finite: about 10^4 b/D.
    constexpr double lift = 1e-4;
    dense.diagonal() *= 1 + lift;
    coarsest_.compute(dense);
}

void Multigrid::operator()(Span<const Real> b, Span<Real> x) const { cycle(0, b, x); }

void Multigrid::cycle(std::size_t l, Span<const Real> b, Span<Real> x) const {
    const Level& level = levels_[l];
    const Index n = level.A.size();
    if (l + 1 == levels_.size()) {
        using Vector = Eigen::Matrix<Real, Eigen::Dynamic, 1>;
        const Eigen::VectorXd solved = coarsest_.solve(Eigen::Map<const Vector>(b.data(), n).cast<double>());
        Eigen::Map<Vector>(x.data(), n) = solved.cast<Real>();
        return;
    }
    const Level& next = levels_[l + 1];
    const SparseRows& A = level.A;
    const auto sweep = [&] {
        A.multiply(x, level.work);
        parallel_for(n, [&](Index i) { x[i] += level.smoothing[i] * (b[i] - level.work[i]); });
    };
    // x = S b, and x += S (b - A x) for each further sweep;  r = b - A x;  x += P (next level) P^T r;  x += S (b - A x)        S = w/D
    parallel_for(n, [&](Index i) { x[i] = level.smoothing[i] * b[i]; });
    for (int k = 1; k < sweeps_before_; ++k) sweep();
    A.multiply(x, level.work);
    parallel_for(n, [&](Index i) { level.work[i] = b[i] - level.work[i]; });
    level.R.multiply(level.work, next.b);
    cycle(l + 1, next.b, next.x);
    level.P.multiply(next.x, level.work);
    parallel_for(n, [&](Index i) { x[i] += level.work[i]; });
    for (int k = 0; k < sweeps_after_; ++k) sweep();
}

std::size_t Multigrid::bytes() const {
    std::size_t sum = 0;
    const auto rows = [](const SparseRows& A) {
        return A.first.size() * sizeof(std::size_t) + A.value.size() * (sizeof(Real) + sizeof(Index));
    };
    for (const Level& level : levels_) sum += rows(level.A) + rows(level.P) + rows(level.R) + 4 * level.b.size() * sizeof(Real);
    return sum + static_cast<std::size_t>(coarsest_.rows() * coarsest_.cols()) * sizeof(double);
}

}  // namespace whorl
