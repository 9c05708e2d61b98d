#pragma once
/// Runs of scenes that a test gives as text.
#include <string>

#include "engine/simulation/simulation.h"

namespace whorl::test {

/// @throws InputError if the text is not a valid scene, or the plan refuses it
Simulation simulation_of(const std::string& text);
/// Steps to `end` [s]. @throws std::runtime_error if the run diverges
void run_until(Simulation& simulation, double end);
/// The whole state that persists between steps, as bytes.
std::string state_of(const Simulation& simulation);
/// Empty if the state at `end` [s] has the same bits on 1 and 4 threads and in a run that was saved half-way; otherwise where it differs.
std::string differing_bits(const std::string& text, double end);

}  // namespace whorl::test
