#pragma once
/// The look, view and material of one image.
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "render/gl/field_texture.h"
#include "render/gl/scene_lighting.h"
#include "render/look/look_options.h"
#include "render/look/material.h"

namespace whorl {

/// Everything that an image is drawn from, except geometry.
struct Shot {
    const LookOptions& look;
    View view;
    Material material;
    float hides = 1;    ///< fraction of the surrounding light that the fluid keeps from objects inside it
    float spacing = 0;  ///< m
    float ground = 0;   ///< m
    Eigen::Matrix4f camera;
    Mat3f to_ray;  ///< position in the image (-1 .. 1, -1 .. 1, 1) -> direction
    float aspect = 1;
    bool blurred = false;    ///< the sum of the samples is blurred along the motion
    bool has_age = false;    ///< the fluid's surface has ages
    bool has_crust = false;  ///< the fluid's surface has plates of crust
    std::vector<EmissivePatch> patches;
    std::set<Pattern> patterns;  ///< textures of the solids
    std::string constants;       ///< GLSL constants of all programs

    /// Whether every pixel needs all samples. Otherwise a pixel that differs little from its neighbours keeps its first sample. The relief
    /// of a crust is found from neighbouring pixels, which later samples would lack.
    bool needs_all_samples() const { return look.samples < 2 || view.blurs() || shows_field(look) || has_crust; }
    /// Height below which nothing is drawn [m].
    float lowest() const { return look.ground ? ground : -1e6f; }
    /// Whether all samples share the solids' light of the first one: they see the solids at the same moment and from about the same
    /// position.
    bool keeps_solid_light() const { return view.open <= 0; }
    bool camera_moves() const { return !(view.position_velocity.isZero(0) && view.target_velocity.isZero(0)); }
    /// Whether the samples look up the background in the backdrop, which shows it from the frame's position. Only the lens moves them.
    bool samples_backdrop() const { return view.aperture > 0 && !(view.open > 0 && camera_moves()) && !is_transparent(look); }
    /// Whether the motion of the camera blurs the background, which the samples do not show.
    bool blurs_background() const { return blurred && !is_transparent(look) && camera_moves(); }
    /// Whether the surface's displacement is stored per pixel: the surface moves while the shutter is open, its distance field does not.
    bool keeps_motion() const { return view.open > 0 && material.refracts; }
};

/// Colour of the fluid drawn as an opaque body.
inline Vec3f body_colour(const Material& material) { return material.refracts ? material.scatter : material.colour; }

}  // namespace whorl
