#pragma once
/// A slice as a plate in a book: flat, as large as the picture has room for, solids in one tone with an outline, words in a margin.
#include "render/flow/slice.h"
#include "render/image/image.h"

namespace whorl {

/// @param range of the colour map
Image draw_plate(const Frame& frame, const LookOptions& look, const std::array<float, 2>& range, int width, int height);

}  // namespace whorl
