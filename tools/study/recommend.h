#pragma once
/// The cheapest settings that reach what a user asks for.
#include <optional>
#include <string>

namespace whorl {

/// "error<2%", "error<0.02", "fps>24", "cost<60".
struct Goal {
    enum class Of { error, fps, cost } of = Of::error;
    double bound = 0;
    std::string text;
    /// Whether a point with these figures fulfils it.
    bool holds(double cost, double error, double fps) const;
};

/// @throws InputError
Goal parse_goal(const std::string& text);

}  // namespace whorl
