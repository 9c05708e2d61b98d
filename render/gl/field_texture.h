#pragma once
/// 3D textures of the fluid: its distance field, and the concentrations of its inks.
#include "engine/io/frame.h"
#include "render/gl/objects.h"
#include "render/look/look_options.h"
#include "render/surface/surface.h"

namespace whorl {

/// Distance field of the fluid: the narrow band at full resolution, and coarse_distance() outside it.
class FieldTexture {
public:
    /// @param band signed distances in a narrow band [m]; an empty volume: no field
    void fill(const Volume& band);
    /// Sets the uniforms of field.glsl; uses texture units `unit` and `unit` + 1.
    void bind(gl::Program& program, int unit) const;
    bool empty() const { return size_.isZero(); }
    float voxel() const { return voxel_; }  ///< m

private:
    gl::Texture near_, far_;
    Vec3f origin_ = Vec3f::Zero(), size_ = Vec3f::Zero();
    Vec3f far_scale_ = Vec3f::Zero(), far_offset_ = Vec3f::Zero(), far_half_ = Vec3f::Zero();
    float voxel_ = 0;
};

/// Signed distances everywhere [m], from distances that are known in a narrow band only: shadow, occlusion and long steps need rough
/// distances everywhere. The voxels are `coarseness` times larger, and `margin` of them are added on every side. The error is about half a
/// coarse voxel.
Volume coarse_distance(const Volume& band, int coarseness, int margin);

/// Inks of the fluid.
class InkField {
public:
    /// Stores the concentrations of the inks. With `body`, the colour of an opaque fluid without inks, it stores the fluid's colours
    /// instead: inks mix as pigments only within a particle, so particles of two inks side by side show both colours.
    /// @param size diagonal of the scene [m] @param drawn whether the look draws the fluid's surface
    void fill(const Frame& frame, const LookOptions& look, float size, bool drawn, const Vec3f* body);
    /// Sets the uniforms of inks.glsl; uses one texture unit.
    /// @param voxel the shader's unit of length [m]; 0 without a distance field, when the fluid is drawn opaque
    void bind(gl::Program& program, int unit, float voxel) const;

private:
    gl::Texture texture_;
    bool any_ = false;
    Vec3f low_ = Vec3f::Zero(), scale_ = Vec3f::Ones();
    Mat3f ratio_ = Mat3f::Zero();       ///< K/S, one column per ink
    Mat3f absorption_ = Mat3f::Zero();  ///< 1/m, one column per ink
    float haze_ = 0;                    ///< 1/m, of thick ink
};

}  // namespace whorl
