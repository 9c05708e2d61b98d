#pragma once
/// Studies whose tables stand in the documentation: each returns Markdown.
#include <string>

namespace whorl {

/// The 3 x 3 pairs of curls and the two Laplacians: error and order against the micropolar Taylor-Green vortex, and what a free blob keeps.
std::string curl_table();
/// Enstrophy and kinetic energy of a three-dimensional Taylor-Green vortex: coarse without, coarse with spin, fine without.
std::string refinement_table();

}  // namespace whorl
