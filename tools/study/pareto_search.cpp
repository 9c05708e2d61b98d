#include "tools/study/pareto_search.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>

namespace whorl {
namespace {

bool counts(const Measured& m) { return std::isfinite(m.cost) && std::isfinite(m.error); }

/// Distance by which a point would extend the front: the smallest shift that the front dominates it again. Negative if the front already
/// dominates it. @param cost, error logarithms
double gain(double cost, double error, const std::vector<Measured>& measured) {
    double least = std::numeric_limits<double>::infinity();
    for (const Measured& m : measured)
        if (counts(m)) least = std::min(least, std::max(std::log(m.cost) - cost, std::log(std::max(m.error, 1e-12)) - error));
    return least;
}

}  // namespace

bool Goal::holds(double cost, double error, double fps) const {
    return of == Of::error ? error < bound : of == Of::fps ? fps > bound : cost < bound;
}

Goal parse_goal(const std::string& text) {
    Goal goal;
    goal.text = text;
    const std::size_t at = std::min(text.find_first_of("<>"), text.size() - 1);
    const std::string name = text.substr(0, text.find_last_not_of(' ', at - 1) + 1), asked = name + text[at];
    char* unit = nullptr;
    goal.bound = std::strtod(text.c_str() + at + 1, &unit);
    goal.of = name == "fps" ? Goal::Of::fps : name == "cost" ? Goal::Of::cost : Goal::Of::error;
    const std::string after = unit;
    if ((asked != "error<" && asked != "fps>" && asked != "cost<") || !(goal.bound > 0) ||
        (!after.empty() && !(after == "%" && name == "error") && !(after == "s" && name == "cost")))
        throw InputError({"--recommend " + text, 0, 0}, "is not a goal", "", "allowed: \"error<2%\", \"fps>24\", \"cost<60\"");
    if (after == "%") goal.bound /= 100;
    return goal;
}

std::vector<std::size_t> pareto_front(const std::vector<Measured>& points) {
    std::vector<std::size_t> order(points.size());
    std::iota(order.begin(), order.end(), 0);
    order.erase(std::remove_if(order.begin(), order.end(), [&](std::size_t i) { return !counts(points[i]); }), order.end());
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return std::pair(points[a].cost, points[a].error) < std::pair(points[b].cost, points[b].error);
    });
    std::vector<std::size_t> front;
    for (const std::size_t i : order)
        if (front.empty() || points[i].error < points[front.back()].error) front.push_back(i);
    return front;
}

ParetoSearch::ParetoSearch(std::vector<int> levels) : levels_(std::move(levels)) {}

std::size_t ParetoSearch::size() const {
    std::size_t n = 1;
    for (const int l : levels_) n *= static_cast<std::size_t>(l);
    return n;
}

GridPoint ParetoSearch::point(std::size_t k) const {
    GridPoint p;
    for (const int l : levels_) p.push_back(static_cast<int>(k % static_cast<std::size_t>(l))), k /= static_cast<std::size_t>(l);
    return p;
}

std::vector<GridPoint> ParetoSearch::first_points() const {
    std::vector<GridPoint> points(3);
    for (const int l : levels_) points[0].push_back(0), points[1].push_back(l - 1), points[2].push_back(l / 2);
    return points;
}

double ParetoSearch::distance(const GridPoint& a, const GridPoint& b) const {
    double sum = 0;
    for (std::size_t k = 0; k < levels_.size(); ++k) sum += std::pow(static_cast<double>(a[k] - b[k]) / std::max(1, levels_[k] - 1), 2);
    return std::sqrt(sum);
}

ParetoSearch::Guess ParetoSearch::guess(const GridPoint& p, const std::vector<Measured>& measured) const {
    // Least-squares fit of a + b.(index) for cost and error. Weights decrease over a third of the grid; a small ridge term sets unknown
    // slopes to 0.
    const auto n = static_cast<Eigen::Index>(levels_.size() + 1);
    Eigen::MatrixXd normal = 1e-3 * Eigen::MatrixXd::Identity(n, n);
    Eigen::MatrixX2d right = Eigen::MatrixX2d::Zero(n, 2);
    Eigen::VectorXd row = Eigen::VectorXd::Ones(n);
    double nearest = std::numeric_limits<double>::infinity();
    for (const Measured& m : measured) {
        if (!counts(m)) continue;
        const double far = distance(p, m.at), weight = std::exp(-4.5 * far * far) + 1e-6;
        nearest = std::min(nearest, far);
        for (std::size_t k = 0; k < levels_.size(); ++k)
            row[static_cast<Eigen::Index>(k) + 1] = static_cast<double>(m.at[k] - p[k]) / std::max(1, levels_[k] - 1);
        normal += weight * row * row.transpose();
        right += weight * row * Eigen::RowVector2d(std::log(m.cost), std::log(std::max(m.error, 1e-12)));
    }
    if (!std::isfinite(nearest)) return {0, 0, nearest};
    const Eigen::MatrixX2d fit = normal.ldlt().solve(right);
    const double slope = n > 1 ? fit.col(1).tail(n - 1).cwiseAbs().maxCoeff() : 0;
    return {fit(0, 0), fit(0, 1), 0.5 * nearest * std::max(slope, 0.5)};
}

Measured ParetoSearch::expected(const GridPoint& p, const std::vector<Measured>& measured) const {
    const Guess g = guess(p, measured);
    return {p, std::exp(g.cost), std::exp(g.error)};
}

GridPoint ParetoSearch::next(const std::vector<Measured>& measured, double most) const {
    const auto was_run = [&](const GridPoint& p) {
        return std::any_of(measured.begin(), measured.end(), [&](const Measured& m) { return m.at == p; });
    };
    const auto too_dear = [&](double cost) {
        return measured.size() > levels_.size() && cost > std::log(most);
    };  // fewer points do not determine a plane
    for (const GridPoint& p : first_points())
        if (!was_run(p) && !too_dear(guess(p, measured).cost)) return p;
    GridPoint best;
    double largest = 0;
    for (std::size_t k = 0; k < size(); ++k) {
        const GridPoint p = point(k);
        if (was_run(p)) continue;
        const Guess g = guess(p, measured);
        const double promise = gain(g.cost, g.error - g.spread, measured);
        if (promise < 0.05 || too_dear(g.cost)) continue;
        const double worth = promise / std::exp(0.5 * g.cost);  // expensive points must extend the front further
        if (worth > largest) largest = worth, best = p;
    }
    return best;
}

}  // namespace whorl
