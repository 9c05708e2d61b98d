#pragma once
/// What a look leaves open for a whole film to have: known before its first picture.
#include <array>

#include "engine/io/frame.h"
#include "engine/sim/simulation.h"
#include "render/look/look_options.h"

namespace whorl {

/// Whether the look shows a field and leaves the range of its colours open.
bool wants_range(const LookOptions& look);

/// The look's own range where it has one. Else an estimate from the scene, the same for every frame of the film and rounded to a number
/// that is easy to read: of speed the largest that the start, the emitters, the solids or a free fall through the domain give; of pressure
/// that of the domain's height full of fluid and of a stop from the largest speed; of density 3 % about rest; of spin and vorticity what
/// the start and the solids' turning give, else the largest speed over eight spacings. Symmetric about zero on a diverging map.
/// @param start the frame at the beginning of the run
std::array<float, 2> film_range(const LookOptions& look, const Simulation& simulation, const Frame& start);
/// The same for a simulation that has not begun.
std::array<float, 2> film_range(const LookOptions& look, const Simulation& simulation);

/// That of density, which goes by the scene alone.
std::array<float, 2> density_range(const Scene& scene);

/// The next of 1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8 times a power of ten. @param value above 0
double round_number_above(double value);

/// Whether the look has streaks or arrows and leaves their time open.
bool wants_streak_time(const LookOptions& look);

/// The way that streaks and arrows of a slice show [s], the same for every frame of the film: as the look says, else as long as a frame
/// lasts, or what the fastest fluid takes for a few hundredths of the domain.
float film_streak_time(const LookOptions& look, const Simulation& simulation);

}  // namespace whorl
