#pragma once
/// Solids where a plane cuts them.
#include <vector>

#include "render/flow/plane_field.h"

namespace whorl {

struct SolidCut {
    bool container = false;      ///< the fluid is inside the outline
    std::vector<float> inside;   ///< share of each pixel that lies within the outline, rows from below; empty where the plane misses it
    std::vector<float> outline;  ///< share of each pixel that its line covers
};

/// @param line width of the outline [pixels]
std::vector<SolidCut> cut_solids(const Frame& frame, const PixelPlane& plane, float line);

}  // namespace whorl
