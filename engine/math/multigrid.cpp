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

/// Finds the connected components of A whose entries add up to 0 within round-off: A does not determine the mean of x there.
std::vector<Multigrid::Component> Multigrid::closed_components(const Eigen::MatrixXd& A) {
    std::vector<Component> closed;
    std::vector<char> reached(static_cast<std::size_t>(A.rows()), 0);
    for (Index first = 0; first < A.rows(); ++first) {
        if (reached[first]) continue;
        Component component;
        component.members = {first};
        reached[first] = 1;
        double sum = 0;
        for (std::size_t head = 0; head < component.members.size(); ++head) {
            const Index i = component.members[head];
            component.diagonal += A(i, i);
            for (Index j = 0; j < A.rows(); ++j) {
                sum += A(i, j);
                if (!reached[j] && A(i, j) != 0) reached[j] = 1, component.members.push_back(j);
            }
        }
        component.diagonal /= static_cast<double>(component.members.size());
        if (component.members.size() == 1) component.diagonal = A.diagonal().mean();  // its own may be 0 within round-off
        constexpr double round_off = 1e-5;                                            // of sums in float
        if (std::abs(sum) < round_off * component.diagonal * static_cast<double>(component.members.size())) closed.push_back(component);
    }
    return closed;
}

void Multigrid::factor(const SparseRows& A) {
    Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(A.size(), A.size());
    for (Index i = 0; i < A.size(); ++i)
        for (std::size_t k = A.first[i]; k < A.first[i + 1]; ++k) dense(i, A.column[k]) = static_cast<double>(A.value[k]);
    dense = (dense + dense.transpose()).eval() / 2;
    for (Index i = 0; i < A.size(); ++i)
        if (!(dense(i, i) > static_cast<double>(min_positive))) dense(i, i) = 1;
    closed_ = closed_components(dense);
    constexpr double lift = 1e-4;
    for (const Component& component : closed_)
        for (Index i : component.members) dense(i, i) *= 1 + lift;
    coarsest_.compute(dense);
    // left(): smallest pivot, relative to the diagonal element of its row. If A is nearly singular, the pivot is only round-off, and its
    // inverse would be noise.
    constexpr double round_off = 1e-3;
    const auto left = [&] { return (coarsest_.matrixLLT().diagonal().array().square() / dense.diagonal().array()).minCoeff(); };
    if (coarsest_.info() == Eigen::Success && left() > round_off) return;
    dense.diagonal() *= 1 + lift;
    coarsest_.compute(dense);
}

/// x = Q (A + lift D)^-1 Q b + (1 - Q) b/D, where Q subtracts the mean over each closed component. Without Q, round-off in the mean of b
/// would be weighted by 1/lift, and conjugate gradients would search along constants, where p.A p is round-off of any sign.
void Multigrid::solve_coarsest(Span<const Real> b, Span<Real> x) const {
    using Vector = Eigen::Matrix<Real, Eigen::Dynamic, 1>;
    const auto n = static_cast<Index>(b.size());
    Eigen::VectorXd v = Eigen::Map<const Vector>(b.data(), n).cast<double>();
    std::vector<double> means;
    const auto subtract_mean = [&](const Component& component) {
        double mean = 0;
        for (Index i : component.members) mean += v[i];
        mean /= static_cast<double>(component.members.size());
        for (Index i : component.members) v[i] -= mean;
        return mean;
    };
    for (const Component& component : closed_) means.push_back(subtract_mean(component));
    coarsest_.solveInPlace(v);
    for (std::size_t k = 0; k < closed_.size(); ++k) {
        subtract_mean(closed_[k]);
        for (Index i : closed_[k].members) v[i] += means[k] / closed_[k].diagonal;
    }
    Eigen::Map<Vector>(x.data(), n) = v.cast<Real>();
}

void Multigrid::operator()(Span<const Real> b, Span<Real> x) const { cycle(0, b, x); }

void Multigrid::cycle(std::size_t l, Span<const Real> b, Span<Real> x) const {
    const Level& level = levels_[l];
    const Index n = level.A.size();
    if (l + 1 == levels_.size()) {
        solve_coarsest(b, x);
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
