#pragma once
/// Two runs at the same time in the pixels of one plane: what the second has more of a field.
#include "render/flow/slice.h"

namespace whorl {

struct DifferenceField {
    PixelPlane plane;
    std::vector<float> value;  ///< of each pixel, in the field's unit
    std::vector<float> cover;  ///< the lesser of both: 0 where one has no fluid .. 1
};

/// @param look whose field it is; of inks the first
DifferenceField difference_field(const Frame& one, const Frame& other, const LookOptions& look, const PixelPlane& plane);
FlowSlice coloured(const DifferenceField& field, const std::string& colour_map, const std::array<float, 2>& range);

}  // namespace whorl
