#pragma once
/// The fluid's distance field on the device: the band as it is, and the far field (far_field.h).
#include "engine/io/frame.h"
#include "render/gl/objects.h"
#include "render/look/look_options.h"
#include "render/surface/surface.h"

namespace whorl {

class FieldTexture {
public:
    void fill(const Volume& band);
    /// Sets the uniforms of field.glsl; takes two texture units from `unit` on.
    void bind(gl::Program& program, int unit) const;
    bool empty() const { return size_.isZero(); }
    float voxel() const { return voxel_; }  ///< m

private:
    gl::Texture near_, far_;
    Vec3f origin_ = Vec3f::Zero(), size_ = Vec3f::Zero();
    Vec3f far_scale_ = Vec3f::Zero(), far_offset_ = Vec3f::Zero(), far_half_ = Vec3f::Zero();
    float voxel_ = 0;
};

/// The distance volume has distances in a narrow band only; shadow, occlusion and long steps need rough ones everywhere.
/// A volume with `coarseness` times larger voxels, `margin` of them wider on every side, whose values are signed distances without a band
/// [m], good to about half a coarse voxel.
Volume coarse_distance(const Volume& band, int coarseness, int margin);

class InkField {
public:
    /// The inks' concentrations, or with `body` (colour of an opaque fluid without inks) its colours: particles of two inks side by side
    /// show both, only inks within one particle mix as pigments.
    /// @param size diagonal of the scene [m] @param drawn whether the look draws the fluid's surface
    void fill(const Frame& frame, const LookOptions& look, float size, bool drawn, const Vec3f* body);
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
