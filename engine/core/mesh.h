#pragma once
/// A triangle mesh: solids that users bring, surfaces that the renderer draws.
#include <array>
#include <vector>

#include "engine/core/types.h"

namespace whorl {

struct TriangleMesh {
    std::vector<Vec3f> position;                         ///< m
    std::vector<Vec3f> normal;                           ///< one a vertex, unit length, outward; may be empty
    std::vector<std::array<std::uint32_t, 3>> triangle;  ///< counter-clockwise seen from outside
    std::vector<float> scalar;                           ///< a value a vertex for colour maps; may be empty
};

}  // namespace whorl
