#pragma once
/// Spray and foam (engine/models/foam/foam.h), drawn as white points around the particles.
#include <vector>

#include "engine/io/frame.h"
#include "render/surface/surface.h"

namespace whorl {

struct FoamPoint {
    Vec3f position, velocity;  ///< m, m/s
    float radius;              ///< m
    float opacity;             ///< 0 .. 1
    bool spray = false;        ///< in the air. Other points belong to the fluid, even if their position is outside its surface
    bool mist = false;         ///< soft disc instead of a sharp point
};

/// Points to draw: up to 48 `amount` around each particle, more the larger its field "foam" is, and one disc of mist, which stands for
/// bubbles smaller than the points. The points move with their particle; those of spray also move apart. Points stay inside containers.
/// Empty if the frame lacks the fields "foam", "airborne" and "grain".
std::vector<FoamPoint> foam_points(const Frame& frame, float amount);

/// Copy of the frame without the particles that are drawn as spray.
Frame without_spray(const Frame& frame);

/// Surface of the fluid, without spray if amount > 0.
Surface build_surface(const Frame& frame, const SurfaceOptions& options, float amount);

}  // namespace whorl
