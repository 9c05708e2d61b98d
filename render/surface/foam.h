#pragma once
/// Spray and foam: the frame's values of air as white points around the particles.
#include <vector>

#include "engine/io/frame.h"
#include "render/surface/surface.h"

namespace whorl {

struct FoamPoint {
    Vec3f position, velocity;  ///< m, m/s
    float radius;              ///< m
    float opacity;             ///< 0 .. 1
    bool spray = false;        ///< flies; otherwise it is in the fluid, also where its place beside the particle is not
    bool mist = false;         ///< a soft blot instead of a sharp point
};

/// Up to 48 `amount` points around each particle, the number by its "foam", at places that move with it, and a blot of mist: points smaller
/// than these. Those of spray part from each other. Points stay inside containers. Empty if the frame has no such fields.
std::vector<FoamPoint> foam_points(const Frame& frame, float amount);

/// The frame without the particles that are drawn as spray.
Frame without_spray(const Frame& frame);

/// Surface of the fluid that foam_points() does not draw as spray.
Surface build_surface(const Frame& frame, const SurfaceOptions& options, float amount);

}  // namespace whorl
