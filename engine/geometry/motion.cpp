#include "engine/geometry/motion.h"

#include <algorithm>
#include <numbers>

#include "engine/core/smooth_keys.h"
#include "engine/geometry/rigid_body.h"

namespace whorl {
namespace {

/// Angular velocity about the own axes of the rotation exp([p]x) while p changes at the rate dp/dt:
/// w = dp/dt - (1 - cos a)/a^2 p x dp/dt + (a - sin a)/a^3 p x (p x dp/dt), a = |p|.
Vec3d spin_of(const Vec3d& p, const Vec3d& rate) {
    const double a = p.norm(), a2 = a * a;
    const double first = a < 1e-3 ? 0.5 - a2 / 24 : (1 - std::cos(a)) / a2,
                 second = a < 1e-3 ? 1.0 / 6 - a2 / 120 : (a - std::sin(a)) / (a2 * a);
    const Vec3d across = p.cross(rate);
    return rate - first * across + second * p.cross(across);
}

}  // namespace

Motion motion_of(std::vector<MotionKey> keys) {
    Motion motion;
    for (const MotionKey& key : keys) {
        motion.moves |= key.position != keys[0].position;
        motion.turns |= key.tilt != keys[0].tilt;
    }
    motion.at = [sorted = std::make_shared<const std::vector<MotionKey>>(by_time(std::move(keys)))](double t) {
        MotionState state;
        Vec3d angle, rate;
        for (int a = 0; a < 3; ++a) {
            const auto x = smooth_between(*sorted, t, [a](const MotionKey& key) { return key.position[a]; });
            const auto p = smooth_between(*sorted, t, [a](const MotionKey& key) { return std::numbers::pi / 180 * key.tilt[a]; });
            state.position[a] = x.value, state.velocity[a] = x.slope, angle[a] = p.value, rate[a] = p.slope;
        }
        state.turn = turn_by(angle);
        state.spin = spin_of(angle, rate);
        return state;
    };
    return motion;
}

}  // namespace whorl
