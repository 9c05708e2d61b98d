#pragma once
/// Walls of a solid of any shape, at which the fluid's surface is cut off.
#include <array>
#include <cmath>
#include <vector>

#include "engine/io/frame.h"

namespace whorl {

/// Plane at which the fluid is cut off.
struct CutSide {
    Vec3f inward = Vec3f::UnitY();                                         ///< unit normal, towards the fluid
    float offset = 0;                                                      ///< m, inward . x of its points
    bool is_wall = true;                                                   ///< wall of a solid; false: side of a periodic domain
    float inside(const Vec3f& x) const { return inward.dot(x) - offset; }  ///< distance from the side [m], negative beyond it
};
/// Whether the sides meet in an edge: the angle between them is too large for facets of one round wall.
inline bool are_across(const CutSide& a, const CutSide& b) { return std::abs(a.inward.dot(b.inward)) < 0.7f; }

/// Signed distance to a solid, from voxels of half a spacing.
class WallField {
public:
    /// @param solid with a closed mesh @param spacing m
    WallField(const FrameSolid& solid, float spacing);

    /// Distance from the solid [m], negative inside it. Limited to 7 spacings in the solid's bounding box.
    float distance(const Vec3f& x) const;
    /// Tangent plane of the nearest wall.
    CutSide side(const Vec3f& x) const;
    /// Adds the tangent planes of the walls about x that are nearer than `reach` [m]: of the nearest one, and of those that meet it at an
    /// edge.
    void add_sides(const Vec3f& x, float reach, std::vector<CutSide>& sides) const;

private:
    struct Sample {
        float distance;  // m
        Vec3f gradient;  // in the solid's axes
    };
    Sample sample(const Vec3f& x) const;

    Mat3f rotation_;
    Vec3f translation_, origin_;
    float voxel_;
    std::array<int, 3> size_{};
    std::vector<float> value_;
};

}  // namespace whorl
