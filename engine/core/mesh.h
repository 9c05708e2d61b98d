#pragma once
/// A triangle mesh: a solid's shape from a file, or a surface to draw.
#include <array>
#include <vector>

#include "engine/core/types.h"

namespace whorl {

struct TriangleMesh {
    std::vector<Vec3f> position;                         ///< m
    std::vector<Vec3f> normal;                           ///< per vertex, unit length, outward; may be empty
    std::vector<std::array<std::uint32_t, 3>> triangle;  ///< counter-clockwise seen from outside
    std::vector<float> scalar;                           ///< per vertex, for colour maps; may be empty
};

}  // namespace whorl
