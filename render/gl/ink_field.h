#pragma once
/// The inks in a fluid that is drawn with its surface, in the memory of the graphics device.
#include "engine/io/frame.h"
#include "render/gl/objects.h"
#include "render/look/look_options.h"

namespace whorl {

class InkField {
public:
    /// @param size diagonal of the scene [m] @param drawn whether the look draws the fluid's surface
    void fill(const Frame& frame, const LookOptions& look, float size, bool drawn);
    /// For inks.glsl. @param voxel the length that absorption is given for [m]; 0: no light goes through
    void bind(gl::Program& program, int unit, float voxel) const;

private:
    gl::Texture texture_;
    bool any_ = false;
    Vec3f low_ = Vec3f::Zero(), scale_ = Vec3f::Ones();
    Mat3f ratio_ = Mat3f::Zero();       ///< K/S, a column an ink
    Mat3f absorption_ = Mat3f::Zero();  ///< 1/m, a column an ink
    float haze_ = 0;                    ///< 1/m
};

}  // namespace whorl
