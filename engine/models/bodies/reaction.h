#pragma once
/// What free bodies get back for what they do to the fluid.
#include "engine/core/parallel.h"
#include "engine/particles/field.h"
#include "engine/particles/surroundings.h"

namespace whorl {

/// Force and torque.
struct Wrench {
    Vec3d force = Vec3d::Zero(), torque = Vec3d::Zero();
    void operator+=(const Wrench& o) { force += o.force, torque += o.torque; }
};

/// The particles that have a solid neighbour of a free body, in order.
std::vector<Index> particles_at_bodies(const Surroundings& around);

/// Adds to every free body the opposite of what its layer does to the particles. It acts where the particle is: whatever the direction of
/// the force, momentum and angular momentum of both together stay.
/// @param act (i, s, r, distance) -> acceleration of particle i by solid particle s [m/s^2]
template <class Act>
void react(const Surroundings& around, Read<field::role> role, const Act& act) {
    if (!around.solids.any_free()) return;
    const std::vector<Index> near = particles_at_bodies(around);
    for (std::size_t k = 0; k < around.solids.all.size(); ++k) {
        if (!around.solids.all[k].body) continue;
        RigidBody& body = *around.solids.all[k].body;
        const Wrench sum = parallel_sum(static_cast<Index>(near.size()), Wrench{}, [&](Index e) {
            Wrench one;
            const Index i = near[e];
            if (role[i] != 0) return one;
            around.solid_pairs.of(i, [&](Index s, const Vec3& r, Real distance) {
                if (static_cast<std::size_t>(around.layer.solid[s]) != k) return;
                const Vec3d force = -act(i, s, r, distance).template cast<double>();
                const Vec3d arm = (around.layer.position[s] + r).template cast<double>() - body.centre;
                one += Wrench{force, arm.cross(force)};
            });
            return one;
        });
        body.force += static_cast<double>(around.step.mass) * sum.force;
        body.torque += static_cast<double>(around.step.mass) * sum.torque;
    }
}

}  // namespace whorl
