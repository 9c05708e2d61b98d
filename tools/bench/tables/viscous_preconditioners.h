#pragma once
/// Iterations and time of the implicit solves by preconditioner, as a part of docs/viscosity.md.

#include <string>
#include <vector>

namespace whorl {

struct PreconditionerRows {
    bool small = true, large = false;          ///< four to fifty thousand particles; half a million
    bool full = true, coupled = true;          ///< which solves
    std::vector<double> K{1, 100, 1250, 1e4};  ///< nu dt/d^2
    std::string only;                          ///< name of the preconditioner whose columns are filled; empty: of all
};

void print_preconditioners(const PreconditionerRows& rows);

}  // namespace whorl
