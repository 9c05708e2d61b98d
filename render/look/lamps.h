#pragma once
/// Lights of a scene, as the shaders use them (studio.glsl, shadow.glsl).
#include <vector>

#include "engine/core/colour.h"

namespace whorl {

/// The illumination of a surface is given as the radiance of a white matt surface.
struct Lamp {
    Vec3f place = Vec3f::UnitY();  ///< position [m]; of a lamp at infinity, unit vector towards it
    bool near = false;             ///< false: at infinity
    float size = 0;                ///< radius of a disc of the same area [m]; at infinity, tangent of its angular radius
    Vec3f axis = Vec3f::Zero(), across = Vec3f::Zero(),
          up = Vec3f::Zero();        ///< of a rectangle: direction in which it shines, half sides [m]
    Vec3f light = Vec3f::Zero();     ///< illumination of a surface that faces it; if near, times the square of the distance [m^2]
    Vec3f radiance = Vec3f::Zero();  ///< of its image in a mirror
};

/// A light of strength 1 illuminates a surface at its target, facing it, with 0.7. The radiance follows from the light's size: a rectangle
/// of area A shines with light pi/A, a ball of radius s with light/s^2, a sun of angular radius a with light/sin(a)^2.
/// @param lights all have targets
std::vector<Lamp> lamps_of(const std::vector<Light>& lights);

}  // namespace whorl
