#pragma once
/// The Pareto front of a sweep, and which point to run next.
#include <limits>

#include "tools/study/study.h"

namespace whorl {

struct Measured {
    GridPoint at;
    double cost = 0, error = 0;  ///< both positive; not finite where the run failed
};

/// A user's requirement for a point: "error<2%", "error<0.02", "fps>24", "cost<60".
struct Goal {
    enum class Of { error, fps, cost } of = Of::error;
    double bound = 0;
    std::string text;
    bool holds(double cost, double error, double fps) const;
};
/// @throws InputError
Goal parse_goal(const std::string& text);

/// Indices of the points that no other beats in both cost and error, from cheap to dear.
std::vector<std::size_t> pareto_front(const std::vector<Measured>& points);

/// Chooses points so that the front is known early: first two opposite corners of the grid and its middle, then always the point whose
/// optimistic guess would push the front furthest for its expected cost. Guesses are local linear fits of the logarithms of cost and error
/// over the knobs' indices; optimistic by a spread that grows with the distance to the measured points. The front counts as known if no
/// point promises to move it by a twentieth.
class ParetoSearch {
public:
    /// @param levels number of values of each knob
    explicit ParetoSearch(std::vector<int> levels);

    /// @param most points that are expected to cost more are left out
    /// @return the next point to run; empty if the front is known (or the grid is exhausted)
    GridPoint next(const std::vector<Measured>& measured, double most = std::numeric_limits<double>::infinity()) const;
    /// Estimate of a point from the measured ones.
    Measured expected(const GridPoint& p, const std::vector<Measured>& measured) const;
    std::size_t size() const;
    GridPoint point(std::size_t k) const;

private:
    struct Guess {
        double cost, error, spread;  ///< logarithms
    };
    Guess guess(const GridPoint& p, const std::vector<Measured>& measured) const;
    std::vector<GridPoint> first_points() const;
    double distance(const GridPoint& a, const GridPoint& b) const;

    std::vector<int> levels_;
};

}  // namespace whorl
