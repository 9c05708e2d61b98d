#pragma once
/// A slice as a plate in a book: flat, as large as the picture has room for, solids in one tone with an outline, words in a margin.
#include "render/flow/slice.h"
#include "render/image/image.h"

namespace whorl {

/// @param range of the colour map
Image draw_slice_image(const Frame& frame, const LookOptions& look, const std::array<float, 2>& range, int width, int height);

/// Difference of a field between another run and this one, on a diverging map, where both have fluid. For inks the first one.
/// @param look of this run, which selects the field; title and legend are of the difference @param range of the difference
Image draw_difference_plate(const Frame& one, const Frame& other, const LookOptions& look, const std::array<float, 2>& range, int width,
                            int height);
/// The difference's size that all but a hundredth of the fluid stays below, looked at on a coarse grid of pixels.
float usual_difference(const Frame& one, const Frame& other, const LookOptions& look);

struct DifferenceField {
    PixelPlane plane;
    std::vector<float> value;  ///< of each pixel, in the field's unit
    std::vector<float> cover;  ///< the lesser of both: 0 where one has no fluid .. 1
};

/// @param look whose field it is; of inks the first
DifferenceField difference_field(const Frame& one, const Frame& other, const LookOptions& look, const PixelPlane& plane);
FlowSlice coloured(const DifferenceField& field, const std::string& colour_map, const std::array<float, 2>& range);

}  // namespace whorl
