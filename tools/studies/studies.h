#pragma once
/// Studies whose tables stand in the documentation: each returns Markdown.
#include <string>

namespace whorl {

/// The 3 x 3 pairs of curls and the two Laplacians: error and order against the micropolar Taylor-Green vortex, and what a free blob keeps.
std::string curl_table();
/// Enstrophy and kinetic energy of a three-dimensional Taylor-Green vortex: coarse without, coarse with spin, fine without.
std::string refinement_table();
/// The same of a Karman street: enstrophy, and the energy of the motion across the stream.
std::string refinement_street_table();
/// Iterations, time and memory of the pressure solves' preconditioners at 1.4e3, 1.1e4 and 1e5 particles, and at 1e6.
std::string preconditioner_table();
std::string preconditioner_table_large();
/// The same at 1e5 particles for other first levels, interpolations and cycles.
std::string hierarchy_table();
/// What a divergence-free velocity keeps of energy, density and period, and what it costs.
std::string divergence_free_table();
/// Wall time with one and with two threads.
std::string thread_table();

}  // namespace whorl
