#pragma once
/// The flow in the pixels of a plane, straight from the particles.
#include <array>
#include <vector>

#include "engine/io/frame.h"

namespace whorl {

/// A rectangle of pixels in the flow, rows from below.
struct PixelPlane {
    Vec3f corner = Vec3f::Zero();                       ///< m, of the first pixel
    Vec3f right = Vec3f::UnitX(), up = Vec3f::UnitY();  ///< unit
    float pixel = 1;                                    ///< m, its edge
    int width = 0, height = 0;
    Vec3f normal() const { return right.cross(up); }
};

struct PlaneField {
    int width = 0, height = 0;
    std::array<std::vector<float>, 2> velocity;  ///< m/s, along right and up; 0 where there is no fluid
    std::array<std::vector<float>, 3> value;     ///< of the field that is shown; those that it does not have are empty
    std::vector<float> cover;                    ///< 0 no fluid near .. 1 full of it
    /// Noise of mean 0 and variance 1 that moves with the particles, in grains of grain_size pixels; empty if particles have no identity.
    std::vector<float> noise;
    float grain_size = 0;
};

/// Each particle's value and gradient, mixed by (1 - r^2/h^2)^2 over two spacings: linear fields are exact, also for uneven
/// particles. The gradient is that of least squares over the neighbours; where they lie in a line, only along it.
/// Bit-identical for any number of threads.
/// @param value of each particle, one to three numbers each
PlaneField plane_field(const Frame& frame, const std::vector<std::vector<float>>& value, const PixelPlane& plane);

}  // namespace whorl
