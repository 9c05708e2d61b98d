#pragma once
/// What free bodies get back for what they do to the fluid.
#include "engine/core/parallel.h"
#include "engine/geometry/solids.h"
#include "engine/particles/field.h"
#include "engine/particles/pairs.h"

namespace whorl {

/// Force and torque.
struct Wrench {
    Vec3d force = Vec3d::Zero(), torque = Vec3d::Zero();
    void operator+=(const Wrench& o) { force += o.force, torque += o.torque; }
};

/// The particles that have a solid neighbour of a free body, in order.
std::vector<Index> particles_at_bodies(const Solids& solids, const SolidPairs& pairs, const SolidParticles& layer);

/// Adds to every free body the opposite of what its layer does to the particles. It acts where the particle is: whatever the direction of
/// the force, momentum and angular momentum of both together stay.
/// @param mass of a particle [kg] @param act (i, s, r, distance) -> acceleration of particle i by solid particle s [m/s^2]
template <class Act>
void react(Solids& solids, const SolidPairs& pairs, const SolidParticles& layer, Real mass, Read<field::role> role, const Act& act) {
    if (!solids.any_free()) return;
    const std::vector<Index> near = particles_at_bodies(solids, pairs, layer);
    for (std::size_t k = 0; k < solids.all.size(); ++k) {
        if (!solids.all[k].body) continue;
        RigidBody& body = *solids.all[k].body;
        const Wrench sum = parallel_sum(static_cast<Index>(near.size()), Wrench{}, [&](Index e) {
            Wrench one;
            const Index i = near[e];
            if (role[i] != 0) return one;
            pairs.of(i, [&](Index s, const Vec3& r, Real distance) {
                if (static_cast<std::size_t>(layer.solid[s]) != k) return;
                const Vec3d force = -act(i, s, r, distance).template cast<double>();
                const Vec3d arm = (layer.position[s] + r).template cast<double>() - body.centre;
                one += Wrench{force, arm.cross(force)};
            });
            return one;
        });
        body.force += static_cast<double>(mass) * sum.force;
        body.torque += static_cast<double>(mass) * sum.torque;
    }
}

}  // namespace whorl
