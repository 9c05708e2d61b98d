#pragma once
/// Ledger of momentum between fluid and solids (docs/physics.md 7).
#include <array>

#include "engine/core/types.h"

namespace whorl {

/// Kinds of force between fluid and solid. `contact`: push-out, contact of `coupled`, pull of wetting.
enum class Push { pressure, viscous, contact };
inline constexpr int pushes = 3;

/// Force and torque [N, N m], or impulse and angular impulse [N s, N m s]; torques are about a solid's centre.
struct Wrench {
    Vec3d force = Vec3d::Zero(), torque = Vec3d::Zero();
    void operator+=(const Wrench& o) { force += o.force, torque += o.torque; }
    friend Wrench operator+(Wrench a, const Wrench& b) { return a += b, a; }
    friend Wrench operator*(double s, const Wrench& w) { return {s * w.force, s * w.torque}; }
    /// At the distance `arm` [m] from the centre.
    static Wrench at(const Vec3d& arm, const Vec3d& force) { return {force, arm.cross(force)}; }
};

/// Impulses of the fluid on a solid over the present step, by kind. In two dimensions for a metre of depth.
struct Ledger {
    std::array<Wrench, pushes> impulse{};
    Wrench& operator[](Push kind) { return impulse[static_cast<std::size_t>(kind)]; }
    const Wrench& operator[](Push kind) const { return impulse[static_cast<std::size_t>(kind)]; }
    Wrench total() const { return impulse[0] + impulse[1] + impulse[2]; }
};

}  // namespace whorl
