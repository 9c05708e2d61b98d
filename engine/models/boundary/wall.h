#pragma once
/// How the fluid feels solids through their one layer of particles (Akinci et al. 2012, volumes 1/sum W), for every model alike.
#include <vector>

#include "engine/geometry/solids.h"
#include "engine/math/kernel.h"
#include "engine/particles/field.h"
#include "engine/particles/interaction_context.h"
#include "engine/particles/step_context.h"

namespace whorl {

/// Correction of the layer's volume, which the notes lack. A single layer with the volumes 1/sum W weighs more than the layer of fluid that
/// it represents (1.43 d^3 a particle on a flat wall with R = 2 d): fluid at rest would hover. With this factor, fluid on a lattice that
/// touches a flat wall feels the same kernel gradient as if the lattice continued behind the wall. 1: as printed.
/// @param support, spacing [m]
Real continued_lattice_factor(KernelForm kernel, Real support, Real spacing);

/// Factor that gives a solid particle of a flat layer, of volume 1/sum W, the volume d^D of a fluid particle: d^D sum W over a
/// square lattice, in 2D over a row.
Real layer_factor(KernelForm kernel, Real support, Real spacing);

/// The slope that sum_j V_j (a_j - a_i) grad W_ij finds on a lattice where it is 1: sum_j V |W'(r_ij)| r_ij/D, 1 for dense neighbours, 1.02
/// with R = 2 d. Sums divided by it are exact there for linear fields.
Real lattice_gradient(KernelForm kernel, Real support, Real spacing);

/// Contribution of a flat wall with continued_lattice_factor() to the kernel sum of a touching particle, times the particle's volume.
Real touching_wall_sum(KernelForm kernel, Real support, Real spacing);

/// Between fluid on a lattice and a flat wall, what the layer at the wall lacks of the pull along the wall, over what the wall adds to its
/// kernel sum: with 1/(1 - this times that sum) the layer's own pairs make good for it.
Real lacking_along_wall(KernelForm kernel, Real support, Real spacing);

/// D over the lattice sum of V |W'(r)| r^3/(r^2 + 0.01 h^2), h = R/2: factor that gives forces along pairs the right stiffness in the mean
/// over directions.
Real along_pairs_factor(KernelForm kernel, Real support, Real spacing);

/// Replaces a solid particle with that normal by the column of lattice layers behind it, as seen by fluid at r: calls f(r_l, |r_l|, d_l)
/// for each of them within the support, with r_l from the layer to the fluid and its depth d_l behind the surface [m].
template <class F>
void each_layer(const Vec3& r, const Vec3& normal, Real spacing, Real support, F&& f) {
    const Real depth = spacing / 2;
    const bool faces = r.dot(normal) > 0;  // else beyond an edge: the column lies on the other side
    for (int l = 0;; ++l) {
        const Vec3 to = r + static_cast<Real>(l) * spacing * normal;
        const Real distance = to.norm();
        if (!(distance < support)) return;
        f(to, distance, depth + static_cast<Real>(l) * spacing);
        if (!faces) return;
    }
}

/// The velocity of a solid as a neighbour of fluid particle i at a no-slip wall. The particles are half a spacing inside
/// the solid; for u to vanish relative to the wall on the solid's surface, not there, the shear is continued behind the surface:
///   u_i - u_s  becomes  stretch (u_i - u_wall),   stretch = 1 + d_s/d_i,
/// with d_s and d_i the depths of s and i behind and before the surface, measured along the normal of s, limited to 3 close to the surface.
struct WallShear {
    Real depth;  ///< m, of the solid particles below the surface: half a spacing
    Real stretch(const Vec3& r, const Vec3& normal) const { return stretch(r, normal, depth); }
    /// stretch() of a layer farther behind the surface. @param r to the solid particle before it @param below that layer's depth [m]
    Real stretch(const Vec3& r, const Vec3& normal, Real below) const {
        const Real height = r.dot(normal);
        if (height <= 0) return 1;  // beyond an edge: the face of s does not face i
        return 1 + below / std::max(height - depth, depth / 2);
    }
};

/// By solid: 1 where the fluid does not stick: the viscous terms leave such solids out, and WallFriction (friction.h) acts at those with a
/// slip length.
std::vector<char> slips(const Solids& solids);

/// A free particle inside a solid is put back on its surface and loses the part of its velocity (relative to the solid) that
/// points into the solid. One that a step brought through a solid, or nearer to its far side, is put back where it met it: so plates of any
/// thickness hold. A free body gets the impulse that the particle loses; the two then part as they meet, with
/// their common mass.
struct PushOutOfSolids {
    void operator()(const InteractionContext& context, Read<field::role> role, Update<field::position> x, Update<field::velocity> u) const;
};

}  // namespace whorl
