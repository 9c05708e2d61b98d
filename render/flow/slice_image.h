#pragma once
/// Image of a slice as in a printed figure: seen face-on, as large as the image allows, solids in one tone with an outline, text in a
/// margin.
#include "render/flow/slice.h"
#include "render/image/image.h"

namespace whorl {

/// @param range of the colour map @param width, height of the image [pixels]
Image draw_slice_image(const Frame& frame, const LookOptions& look, const std::array<float, 2>& range, int width, int height);

/// Difference of a field, `other` minus `one`, on a diverging map, in the pixels that have fluid in both frames. Of inks: the first.
/// @param look of `one`, which selects the field; title and legend describe the difference @param range of the difference
Image draw_difference_plate(const Frame& one, const Frame& other, const LookOptions& look, const std::array<float, 2>& range, int width,
                            int height);
/// 99th percentile of the finite values' magnitudes; 0 without values.
float usual_size(std::vector<float> values);
/// usual_size() of the difference over the fluid, on a plane of 160 pixels along its longer side; 0 without fluid.
float usual_difference(const Frame& one, const Frame& other, const LookOptions& look);

}  // namespace whorl
