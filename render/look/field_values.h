#pragma once
/// Values of the field that colours the particles, and the resulting colours.
#include <vector>

#include "engine/io/frame.h"
#include "render/look/look_options.h"

namespace whorl {

/// Value per particle: speed [m/s], norm of a vector field (on a diverging map its z component), or a scalar field. Zeros if the frame
/// does not contain the field.
std::vector<float> field_values(const Frame& frame, const LookOptions& look);
/// The look's range. If it is empty: the range of the values, symmetric about zero on a diverging map; Q starts at 0 on other maps.
std::array<float, 2> field_range(const std::vector<float>& values, const LookOptions& look);

/// Unit of a quantity, such as "m/s"; empty for pure numbers.
std::string unit_of(const std::string& quantity);

/// Colours of the particles.
struct FieldColours {
    std::vector<Vec3f> colour;    ///< linear RGB
    std::vector<float> strength;  ///< 0 .. 1, distance from the range's lower bound, or on a diverging map from its middle
};
FieldColours field_colours(const Frame& frame, const LookOptions& look, const std::array<float, 2>& range);

/// The ink markers as particles of a frame, with zero velocity. If the run has no markers: the particles with their own inks.
Frame inked_points(const Frame& frame);

/// Fields that an image needs in addition to positions and velocities.
std::vector<std::string> shown_fields(const LookOptions& look);

}  // namespace whorl
