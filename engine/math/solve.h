#pragma once
/// Parameters and results of linear solvers.
#include <string>

namespace whorl {

struct SolveLimits {
    double tolerance = 1e-4;  ///< largest residual relative to the right-hand side, in the norm that the solver documents
    int max_iterations = 200;
};

struct SolveReport {
    int iterations = 0;
    double first_residual = 0, last_residual = 0;  ///< relative, in the norm that stops the solver
    bool converged = false;
    std::string why_not;                           ///< empty if it converged
    int levels = 1;                                ///< number of levels of the preconditioner; 1: no hierarchy
    double set_up_seconds = 0, solve_seconds = 0;  ///< wall time
};

}  // namespace whorl
