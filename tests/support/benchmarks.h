#pragma once
/// The scenes of scenes/studies/benchmarks and their tables, for tests that compare them with theory and published figures.
#include <map>
#include <string>
#include <vector>

#include "engine/simulation/simulation.h"

namespace whorl::test {

using Table = std::map<std::string, std::vector<double>>;  ///< columns by name

/// scenes/NAME.toml. @param changes "key=value", laid over the file
Scene shipped_scene(const std::string& name, const std::vector<std::string>& changes);

/// The scene of this name in scenes/studies/benchmarks. @param changes "key=value", laid over the file
Simulation benchmark(const std::string& name, const std::vector<std::string>& changes = {});

/// Current values of the scene's probe of this name.
Table reading(const Simulation& simulation, const std::string& probe);

/// Columns of numbers of the CSV file of this name in the scenes' folder.
Table reference(const std::string& name);

/// Value at x of a function given at ascending points, by the cubic through the four nearest.
double between(const std::vector<double>& places, const std::vector<double>& values, double x);

}  // namespace whorl::test
