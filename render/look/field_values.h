#pragma once
/// The field that colours particles, as places on a colour map.
#include <vector>

#include "engine/io/frame.h"
#include "render/look/look_options.h"

namespace whorl {

/// One value a particle: speed [m/s], the norm of a vector field (its component along z on a diverging map), or a scalar field.
/// Zeros where the frame does not carry the field.
std::vector<float> field_values(const Frame& frame, const LookOptions& look);
/// The look's range; where it is empty the values' own, symmetric about zero on a diverging map.
std::array<float, 2> field_range(const std::vector<float>& values, const LookOptions& look);

/// Unit of a particle's quantity, "m/s"; empty for pure numbers.
std::string unit_of(const std::string& quantity);

/// Colours of the particles.
struct FieldColours {
    std::vector<Vec3f> colour;    ///< linear RGB
    std::vector<float> strength;  ///< 0 .. 1, how far the field is from nothing: from the range's low end, or on a diverging map its middle
};
FieldColours field_colours(const Frame& frame, const LookOptions& look, const std::array<float, 2>& range);

/// The ink markers as the particles of a frame at rest, or the particles with their own inks if the run has no markers.
Frame inked_points(const Frame& frame);

/// Fields that an image needs in addition to positions and velocities.
std::vector<std::string> shown_fields(const LookOptions& look);

}  // namespace whorl
