#pragma once
/// Iterations and time of the implicit solves by preconditioner, as a part of docs/viscosity.md.

namespace whorl {

/// @param large also half a million particles
void print_preconditioners(bool large);

}  // namespace whorl
