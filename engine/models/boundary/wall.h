#pragma once
/// Interaction of the fluid with solids through one layer of boundary particles (Akinci et al. 2012, volumes 1/sum W), for all models.
#include <vector>

#include "engine/geometry/solids.h"
#include "engine/math/kernel.h"
#include "engine/particles/field.h"
#include "engine/particles/interaction_context.h"
#include "engine/particles/step_context.h"

namespace whorl {

/// Factor that corrects the volumes of boundary particles; the notes have 1. A single layer with the volumes 1/sum W weighs more than the
/// layer of fluid that it represents (1.43 d^3 per particle on a flat wall with R = 2 d), so fluid at rest would hover. With this factor,
/// fluid on a lattice that touches a flat wall has the same kernel gradient as if the lattice continued behind the wall.
/// @param support, spacing [m]
Real continued_lattice_factor(KernelForm kernel, Real support, Real spacing);

/// Factor that converts the volume 1/sum W of a boundary particle on a flat wall to the volume d^D of a fluid particle, D the number of
/// dimensions. The factor is d^D sum W over a square lattice, in 2D over a row.
Real layer_factor(KernelForm kernel, Real support, Real spacing);

/// Value of sum_j V_j (a_j - a_i) grad W_ij on a lattice for a linear field a of slope 1. It is sum_j V |W'(r_ij)| r_ij/D: 1 for dense
/// neighbours, 1.02 with R = 2 d, in D dimensions. Sums divided by this value are exact for linear fields on the lattice.
Real lattice_gradient(KernelForm kernel, Real support, Real spacing);

/// Contribution of a flat wall with continued_lattice_factor() to the kernel sum of a touching particle, times the particle's volume.
Real touching_wall_sum(KernelForm kernel, Real support, Real spacing);

/// For fluid on a lattice at a flat wall. The layer that touches the wall lacks a fraction of the pair forces along the wall. Returns this
/// fraction, divided by the wall's contribution w to the layer's kernel sum. The factor 1/(1 - w times the result) on the layer's own pairs
/// compensates for the lack.
Real lacking_along_wall(KernelForm kernel, Real support, Real spacing);

/// D/(lattice sum of V |W'(r)| r^3/(r^2 + 0.01 h^2)), h = R/2, in D dimensions. With this factor the stiffness of forces along pairs is
/// right in the mean over directions.
Real along_pairs_factor(KernelForm kernel, Real support, Real spacing);

/// Replaces a boundary particle by the column of lattice layers behind it, along its normal. Calls f(r_l, |r_l|, d_l) for each layer within
/// the support, with the vector r_l from the layer to the fluid particle and the layer's depth d_l behind the surface [m]. @param r from
/// the boundary particle to the fluid particle
template <class F>
void each_layer(const Vec3& r, const Vec3& normal, Real spacing, Real support, F&& f) {
    const Real depth = spacing / 2;
    const bool faces = r.dot(normal) > 0;  // false: fluid is beyond an edge, the column lies on the other side
    for (int l = 0;; ++l) {
        const Vec3 to = r + static_cast<Real>(l) * spacing * normal;
        const Real distance = to.norm();
        if (!(distance < support)) return;
        f(to, distance, depth + static_cast<Real>(l) * spacing);
        if (!faces) return;
    }
}

/// Velocity of a solid as a neighbour of fluid particle i at a no-slip wall. Boundary particles lie half a spacing inside the solid, but u
/// has to vanish relative to the wall on the solid's surface. So the shear is continued behind the surface:
///   u_i - u_s  becomes  stretch (u_i - u_wall),   stretch = 1 + d_s/d_i,
/// d_s is the depth of s below the surface and d_i the height of i above it, both along the normal of s. Near the surface the stretch is
/// limited to 3.
struct WallShear {
    Real depth;  ///< depth of the boundary particles below the surface, half a spacing [m]
    Real stretch(const Vec3& r, const Vec3& normal) const { return stretch(r, normal, depth); }
    /// Stretch for a layer farther behind the surface. @param r from the boundary particle to the fluid particle @param below depth of the
    /// layer [m]
    Real stretch(const Vec3& r, const Vec3& normal, Real below) const {
        const Real height = r.dot(normal);
        if (height <= 0) return 1;  // beyond an edge: the face of s does not face i
        return 1 + below / std::max(height - depth, depth / 2);
    }
};

/// By solid: 1 if the fluid does not stick to the solid. The viscous terms omit such solids. If such a solid has a slip length,
/// WallFriction (friction.h) acts on it.
std::vector<char> slips(const Solids& solids);

/// Puts a free particle that is inside a solid back on its surface and removes the part of its velocity (relative to the solid) that points
/// into the solid. If a step took a particle through a solid, or closer to the far side of the solid than to the side where it entered, the
/// particle is put back at the point where it met the surface. So plates of any thickness are tight. A free body receives the impulse that
/// the particle loses; the collision is inelastic.
struct PushOutOfSolids {
    /// Least distance to solids other than free bodies, in spacings. Weakly compressible particles at the edge of a free surface have no
    /// pressure that keeps them off a wall.
    Real clearance = 0;
    void operator()(const InteractionContext& context, Read<field::role> role, Update<field::position> x, Update<field::velocity> u) const;
};

}  // namespace whorl
