#pragma once
/// Frames of fluid whose flow is known.
#include "engine/core/random.h"
#include "engine/io/frame.h"

namespace whorl::test {

/// A square or cube of 1 m, 20 particles wide, with the velocity u(x) and a grain.
/// @param off largest distance from the lattice along each axis, over the spacing
template <class F>
Frame square_or_cube(int dimensions, float off, F&& u) {
    constexpr float d = 0.05f;
    Frame frame;
    frame.spacing = d, frame.dimensions = dimensions;
    frame.domain_min = Vec3f::Zero(), frame.domain_max = Vec3f(1, 1, dimensions == 3 ? 1 : 0);
    RandomNumbers random(3);
    const auto shift = [&] { return off * d * static_cast<float>(2 * random() - 1); };
    for (int k = 0; k < (dimensions == 3 ? 20 : 1); ++k)
        for (int j = 0; j < 20; ++j)
            for (int i = 0; i < 20; ++i) {
                const Vec3f cell(static_cast<float>(i), static_cast<float>(j), static_cast<float>(k));
                Vec3f x = d * (cell + Vec3f::Constant(0.5f)) + Vec3f(shift(), shift(), shift());
                if (dimensions == 2) x.z() = 0;
                frame.position.push_back(x);
                frame.velocity.push_back(u(x));
                frame.scalar["grain"].push_back(static_cast<float>(random()));
            }
    return frame;
}

/// A turn about the middle at 1 rad/s.
inline Vec3f turning(const Vec3f& x) { return Vec3f(0.5f - x.y(), x.x() - 0.5f, 0); }

}  // namespace whorl::test
