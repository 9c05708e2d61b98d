#pragma once
/// Two-point boundary value problems y' = f(y) on 0 <= s <= 1 with conditions at both ends. Collocation of fourth order (Lobatto IIIA, as
/// in Kierzenka & Shampine 2001): the cubic through values and slopes of two nodes also satisfies the equation at their midpoint. Newton's
/// method uses exact Jacobians. even_mesh() distributes the nodes such that all intervals have about the same error. Represent an unknown
/// constant by a function with slope zero.
///
/// A problem has
///     static constexpr int functions, start_conditions;          the others are end conditions
///     template <class T> Vector<T, functions> slope(const Vector<T, functions>& y) const;
///     template <class T> Vector<T, start_conditions> at_start(const Vector<T, functions>& y) const;                 zero if satisfied
///     template <class T> Vector<T, functions - start_conditions> at_end(const Vector<T, functions>& y) const;
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <unsupported/Eigen/AutoDiff>
#include <vector>

#include "engine/math/solve.h"

namespace whorl {

template <class T, int n>
using Vector = Eigen::Matrix<T, n, 1>;

/// Functions, as values at the nodes of a mesh.
template <int n>
struct Curve {
    std::vector<double> s;  ///< nodes from 0 to 1, ascending
    std::vector<Vector<double, n>> y;
};

template <class Problem>
class Collocation {
public:
    static constexpr int n = Problem::functions, first = Problem::start_conditions, last = n - first;
    using Values = Vector<double, n>;

    /// Solves on the mesh of `curve`. A Newton step is halved up to four times until it reduces the residual.
    /// @param curve (in) first guess, (out) solution
    /// @param limits tolerance of the last Newton step, relative to 1 + |y|; number of Newton steps
    /// @return residuals: root of the sum of the squared conditions at both ends and the mean square of the defects (per interval length,
    /// relative to 1 + |y'|)
    static SolveReport solve(const Problem& problem, Curve<n>& curve, SolveLimits limits);
    /// A mesh of `intervals` intervals that each contribute about the same error of `curve`.
    static std::vector<double> even_mesh(const Problem& problem, const Curve<n>& curve, int intervals);
    /// The curve interpolated at the nodes of another mesh.
    static Curve<n> on_mesh(const Problem& problem, const Curve<n>& curve, const std::vector<double>& mesh);

private:
    using Matrix = Eigen::Matrix<double, n, n>;
    class Cubics;
    static constexpr int rows = first + n;  ///< rows eliminated together: conditions on a node, and defects of the interval that follows

    template <int m, class F>
    static Vector<double, m> with_jacobian(const F& f, const Values& y, Eigen::Matrix<double, m, n>& jacobian);
    static Values slope(const Problem& problem, const Values& y) { return problem.slope(y); }
    static Values slope(const Problem& problem, const Values& y, Matrix& jacobian) {
        return with_jacobian<n>([&](const auto& v) { return problem.slope(v); }, y, jacobian);
    }
    static double residual(const Problem& problem, const Curve<n>& curve);
    static std::vector<Values> newton_step(const Problem& problem, const Curve<n>& curve);
    template <class Block>
    static bool eliminate(Block& block, int columns);
};

template <class Problem>
template <int m, class F>
Vector<double, m> Collocation<Problem>::with_jacobian(const F& f, const Values& y, Eigen::Matrix<double, m, n>& jacobian) {
    using Varying = Eigen::AutoDiffScalar<Values>;  // a number with its derivatives with respect to the functions
    Vector<Varying, n> varying;
    for (int k = 0; k < n; ++k) varying[k] = Varying(y[k], n, k);
    const Vector<Varying, m> result = f(varying);
    Vector<double, m> values;
    for (int k = 0; k < m; ++k) values[k] = result[k].value(), jacobian.row(k) = result[k].derivatives().transpose();
    return values;
}

template <class Problem>
double Collocation<Problem>::residual(const Problem& problem, const Curve<n>& curve) {
    double sum = problem.at_start(curve.y.front()).squaredNorm() + problem.at_end(curve.y.back()).squaredNorm();
    Values left = slope(problem, curve.y[0]);
    for (std::size_t i = 0; i + 1 < curve.s.size(); ++i) {
        const double h = curve.s[i + 1] - curve.s[i];
        const Values right = slope(problem, curve.y[i + 1]);
        const Values middle = slope(problem, 0.5 * (curve.y[i] + curve.y[i + 1]) + h / 8 * (left - right));
        const Values defect = (curve.y[i + 1] - curve.y[i]) / h - (left + 4 * middle + right) / 6;
        sum += h * (defect.array() / (1 + middle.array().abs())).square().sum();
        left = right;
    }
    return std::sqrt(sum);
}

/// Gaussian elimination with partial pivoting on the leading columns. @return false if the block is singular
template <class Problem>
template <class Block>
bool Collocation<Problem>::eliminate(Block& block, int columns) {
    Eigen::Matrix<double, Block::RowsAtCompileTime, 1> factors;
    for (int k = 0; k < columns; ++k) {
        const auto below = block.rows() - k - 1;
        Eigen::Index pivot = 0;
        if (!(block.col(k).tail(below + 1).cwiseAbs().maxCoeff(&pivot) > 1e-200)) return false;
        if (pivot > 0) block.row(k).swap(block.row(k + pivot));
        factors.tail(below) = block.col(k).tail(below) / block(k, k);
        for (Eigen::Index j = k + 1; j < block.cols(); ++j)
            if (const double top = block(k, j); top != 0) block.col(j).tail(below) -= top * factors.tail(below);
    }
    return true;
}

// Defect of an interval of length h from node 0 to node 1:   D = y_1 - y_0 - h/6 (f_0 + 4 f_m + f_1),
//     f_m = f((y_0 + y_1)/2 + h/8 (f_0 - f_1)),
//     dD/dy_0 = -1 - h/6 (J_0 + 2 J_m) - h^2/12 J_m J_0,   dD/dy_1 = 1 - h/6 (J_1 + 2 J_m) + h^2/12 J_m J_1,
// with the Jacobians J of f. From the start on, the conditions on a node are eliminated together with the defects of the interval that
// follows the node. n of the rows give the Newton step of that node as a function of the next node's step; the other rows become
// conditions on the next node. Pivoting among all these rows keeps both growing and decaying solutions bounded.
template <class Problem>
std::vector<typename Collocation<Problem>::Values> Collocation<Problem>::newton_step(const Problem& problem, const Curve<n>& curve) {
    const std::size_t intervals = curve.s.size() - 1;
    std::vector<Matrix> upper(intervals);
    std::vector<Eigen::Matrix<double, n, n + 1>> coupling(intervals);
    Eigen::Matrix<double, first, n> at_start;
    Eigen::Matrix<double, first, n + 1> condition;
    condition.col(n) = -with_jacobian<first>([&](const auto& v) { return problem.at_start(v); }, curve.y[0], at_start);
    condition.template leftCols<n>() = at_start;
    Eigen::Matrix<double, rows, 2 * n + 1> block;
    Matrix j_left, j_middle, j_right;
    Values left = slope(problem, curve.y[0], j_left);
    for (std::size_t i = 0; i < intervals; ++i) {
        const double h = curve.s[i + 1] - curve.s[i];
        const Values right = slope(problem, curve.y[i + 1], j_right);
        const Values middle = slope(problem, 0.5 * (curve.y[i] + curve.y[i + 1]) + h / 8 * (left - right), j_middle);
        block.setZero();
        block.template topLeftCorner<first, n>() = condition.template leftCols<n>();
        block.template topRightCorner<first, 1>() = condition.col(n);
        block.template block<n, n>(first, 0) = -Matrix::Identity() - h / 6 * (j_left + 2 * j_middle) - h * h / 12 * (j_middle * j_left);
        block.template block<n, n>(first, n) = Matrix::Identity() - h / 6 * (j_right + 2 * j_middle) + h * h / 12 * (j_middle * j_right);
        block.template bottomRightCorner<n, 1>() = curve.y[i] - curve.y[i + 1] + h / 6 * (left + 4 * middle + right);
        if (!eliminate(block, n)) return {};
        upper[i] = block.template topLeftCorner<n, n>();
        coupling[i] = block.template topRightCorner<n, n + 1>();
        condition = block.template bottomRightCorner<first, n + 1>();
        left = right, j_left = j_right;
    }
    Eigen::Matrix<double, last, n> at_end;
    Eigen::Matrix<double, n, n + 1> end;
    end.template topRows<first>() = condition;
    end.template bottomRightCorner<last, 1>() =
        -with_jacobian<last>([&](const auto& v) { return problem.at_end(v); }, curve.y.back(), at_end);
    end.template bottomLeftCorner<last, n>() = at_end;
    if (!eliminate(end, n)) return {};
    std::vector<Values> step(intervals + 1);
    step[intervals] = end.template leftCols<n>().template triangularView<Eigen::Upper>().solve(end.col(n));
    for (std::size_t i = intervals; i-- > 0;)
        step[i] =
            upper[i].template triangularView<Eigen::Upper>().solve(coupling[i].col(n) - coupling[i].template leftCols<n>() * step[i + 1]);
    return step;
}

template <class Problem>
SolveReport Collocation<Problem>::solve(const Problem& problem, Curve<n>& curve, SolveLimits limits) {
    constexpr int most_halvings = 4;
    constexpr double rounding = 1e-9;  // residuals below this need not decrease further
    SolveReport report;
    report.first_residual = report.last_residual = residual(problem, curve);
    Curve<n> trial;
    trial.s = curve.s, trial.y.resize(curve.y.size());
    while (report.iterations < limits.max_iterations) {
        ++report.iterations;
        const std::vector<Values> step = newton_step(problem, curve);
        double size = step.empty() ? INFINITY : 0;
        for (std::size_t i = 0; i < step.size(); ++i)
            size = std::max(size, (step[i].array().abs() / (1 + curve.y[i].array().abs())).maxCoeff());
        if (!std::isfinite(size)) return report.why_not = "the linear system is singular", report;
        double part = 1, now = INFINITY;
        const auto lessens = [&] { return std::isfinite(now) && (now < (1 - 0.2 * part) * report.last_residual || now < rounding); };
        for (int halvings = 0; halvings <= most_halvings && !lessens(); ++halvings) {
            part = std::ldexp(1.0, -halvings);
            for (std::size_t i = 0; i < step.size(); ++i) trial.y[i] = curve.y[i] + part * step[i];
            now = residual(problem, trial);
        }
        report.converged = size * part < limits.tolerance;
        if (lessens()) curve.y.swap(trial.y), report.last_residual = now;
        else if (!report.converged)
            return report.why_not = "no fraction (1 to 1/16) of the Newton step reduces the residual enough", report;
        if (report.converged) return report;
    }
    report.why_not = "not converged within the allowed steps";
    return report;
}

template <class Problem>
class Collocation<Problem>::Cubics {
public:
    Cubics(const Problem& problem, const Curve<n>& curve) : curve_(curve) {
        for (const Values& y : curve.y) f_.push_back(problem.slope(y));
    }
    /// Value at fraction q of interval i.
    Values value(std::size_t i, double q) const {
        const double h = curve_.s[i + 1] - curve_.s[i], p = 1 - q;
        return p * p * (1 + 2 * q) * curve_.y[i] + q * q * (3 - 2 * q) * curve_.y[i + 1] + h * q * p * (p * f_[i] - q * f_[i + 1]);
    }
    Values slope(std::size_t i, double q) const {
        const double h = curve_.s[i + 1] - curve_.s[i], p = 1 - q;
        return 6 * q * p / h * (curve_.y[i + 1] - curve_.y[i]) + p * (1 - 3 * q) * f_[i] + q * (3 * q - 2) * f_[i + 1];
    }

private:
    const Curve<n>& curve_;
    std::vector<Values> f_;
};

template <class Problem>
Curve<Collocation<Problem>::n> Collocation<Problem>::on_mesh(const Problem& problem, const Curve<n>& curve,
                                                             const std::vector<double>& mesh) {
    const Cubics cubics(problem, curve);
    Curve<n> other;
    other.s = mesh;
    std::size_t i = 0;
    for (const double s : mesh) {
        while (i + 2 < curve.s.size() && curve.s[i + 1] < s) ++i;
        other.y.push_back(cubics.value(i, (s - curve.s[i]) / (curve.s[i + 1] - curve.s[i])));
    }
    return other;
}

// The cubic satisfies y' = f at the ends and the middle of an interval. The error of an interval is the defect of the cubic at two points
// between these (sqrt(3/7) of half an interval from the middle). It is of fourth order, so the density of nodes follows its fourth root.
// An interval is at most twice as long as the mean.
template <class Problem>
std::vector<double> Collocation<Problem>::even_mesh(const Problem& problem, const Curve<n>& curve, int intervals) {
    const Cubics cubics(problem, curve);
    const std::size_t old = curve.s.size() - 1;
    const auto length = [&](std::size_t i) { return curve.s[i + 1] - curve.s[i]; };
    std::vector<double> root(old), density(old), before(old + 1, 0.0);
    double roots = 0;
    for (std::size_t i = 0; i < old; ++i) {
        double error = 0;
        for (const double side : {-1.0, 1.0}) {
            const double q = 0.5 + side * 0.5 * std::sqrt(3.0 / 7);
            const Values wanted = problem.slope(cubics.value(i, q));
            error += ((cubics.slope(i, q) - wanted).array() / (1 + wanted.array().abs())).square().sum();
        }
        roots += root[i] = std::pow(std::max(error, 1e-24), 1.0 / 8);
    }
    for (std::size_t i = 0; i < old; ++i) density[i] = root[i] / roots / length(i) + 0.5;
    for (std::size_t i = 0; i < old; ++i) {  // adjacent intervals must be of similar length
        const std::size_t from = i < 2 ? 0 : i - 2, to = std::min(old, i + 3);
        double mean = 0;
        for (std::size_t k = from; k < to; ++k) mean += density[k] / static_cast<double>(to - from);
        before[i + 1] = before[i] + std::max(mean, 0.7 * density[i]) * length(i);
    }
    std::vector<double> mesh{0};
    std::size_t i = 0;
    for (int k = 1; k < intervals; ++k) {
        const double at = before[old] * k / intervals;
        while (i + 1 < old && before[i + 1] < at) ++i;
        mesh.push_back(curve.s[i] + (at - before[i]) / (before[i + 1] - before[i]) * length(i));
    }
    mesh.push_back(1);
    return mesh;
}

}  // namespace whorl
