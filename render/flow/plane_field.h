#pragma once
/// Fields of the flow in the pixels of a plane, computed directly from the particles.
#include <array>
#include <vector>

#include "engine/io/frame.h"

namespace whorl {

/// A rectangle of pixels in space, rows from below.
struct PixelPlane {
    Vec3f corner = Vec3f::Zero();                       ///< m, outer corner of the first pixel
    Vec3f right = Vec3f::UnitX(), up = Vec3f::UnitY();  ///< unit vectors
    float pixel = 1;                                    ///< m, edge of a pixel
    int width = 0, height = 0;
    Vec3f normal() const { return right.cross(up); }
};

/// Fields per pixel of a plane.
struct PlaneField {
    int width = 0, height = 0;
    std::array<std::vector<float>, 2> velocity;  ///< m/s, along right and up; 0 without fluid
    std::array<std::vector<float>, 3> value;     ///< components of the shown field; 0 without fluid; unused ones are empty
    std::vector<float> cover;                    ///< 0 no fluid nearby .. 1 full of fluid
    /// Noise of mean 0 and variance 1 that moves with the particles; empty if the frame has no "grain".
    std::vector<float> noise;
    float grain_size = 0;  ///< pixels, radius of a grain of the noise
};

/// Mean over the particles within h of each pixel, weighted by (1 - r^2/h^2)^2, of their values extrapolated by their gradients; h is two
/// spacings, and at least 1.2 pixels. Linear fields are exact, even for irregular particles. Gradients are least-squares fits over the
/// neighbours; if the neighbours lie on a line, the gradient is along it. Bit-identical for any number of threads.
/// @param value up to three fields, each with one number per particle
/// @param bounded shortens gradients and limits means, so that no value leaves the range of the particles around it: for inks, which change
/// within a spacing
PlaneField plane_field(const Frame& frame, const std::vector<std::vector<float>>& value, const PixelPlane& plane, bool bounded = false);

}  // namespace whorl
