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

/// The particles near a plane, sorted by cells.
struct PlaneParticles {
    /// Particles within `reach` [m] of the rectangle and of the plane, including periodic images.
    PlaneParticles(const Frame& frame, const PixelPlane& plane, float reach);

    std::vector<Vec3f> at;                ///< m from the corner, along right, up and the normal
    std::vector<std::uint32_t> particle;  ///< its number in the frame
    float reach = 0;                      ///< m

    /// Calls f(i) for all in cells that touch the rectangle, in an order that only the frame decides.
    template <class F>
    void within(float x0, float y0, float x1, float y1, const F& f) const {
        const int a = column(x0), b = column(x1), c = row(y0), d = row(y1);
        for (int y = c; y <= d; ++y)
            for (std::uint32_t i = first_[y * across_ + a]; i < first_[y * across_ + b + 1]; ++i) f(i);
    }
    template <class F>
    void around(const Eigen::Vector2f& x, float distance, const F& f) const {
        within(x.x() - distance, x.y() - distance, x.x() + distance, x.y() + distance, f);
    }

private:
    int column(float x) const { return std::clamp(static_cast<int>((x + margin_) / cell_), 0, across_ - 1); }
    int row(float y) const { return std::clamp(static_cast<int>((y + margin_) / cell_), 0, rows_ - 1); }
    float margin_ = 0, cell_ = 0;
    int across_ = 0, rows_ = 0;
    std::vector<std::uint32_t> first_;
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
