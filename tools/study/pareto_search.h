#pragma once
/// Pareto front of a sweep, and the choice of the next point to run.
#include <limits>

#include "tools/study/study.h"

namespace whorl {

struct Measured {
    GridPoint at;
    double cost = 0, error = 0;  ///< both positive; not finite if the run failed
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

/// Indices of the points that no other point beats in both cost and error, in order of increasing cost.
std::vector<std::size_t> pareto_front(const std::vector<Measured>& points);

/// Chooses points so that the front is known early: first two opposite corners of the grid and its middle, then each time the point that
/// may extend the front most for its expected cost. Cost and error of a point are estimated by local linear fits of their logarithms over
/// the knobs' indices. The estimated error is reduced by a spread that grows with the distance to the measured points. The front counts as
/// known if no point is expected to move it by a twentieth.
class ParetoSearch {
public:
    /// @param levels number of values of each knob
    explicit ParetoSearch(std::vector<int> levels);

    /// @param most cost above which points are left out, by their expected cost
    /// @return the next point to run; empty if the front is known (or the grid is exhausted)
    GridPoint next(const std::vector<Measured>& measured, double most = std::numeric_limits<double>::infinity()) const;
    /// Expected cost and error of a point, from the measured ones.
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
