#pragma once
/// Options of the coupled solve. Lengths in spacings d.
#include <algorithm>

#include "engine/core/types.h"
#include "engine/math/solve.h"

namespace whorl {

struct CoupledOptions {
    /// On sqrt(r.M r) / sqrt(b.M b), which follows the velocity's error: 3e-3 suffices for coils, stretched threads want 1e-3. It is for a
    /// step in which the fastest fluid moves by 0.4 d; shorter steps get their share.
    SolveLimits limits{1e-3, 300};

    double support = 2.4, widest_support = 4;  ///< kernel radius; it grows where a particle has fewer than enough() neighbours
    double widest() const { return std::max(support, widest_support); }
    int enough_neighbours = 16, enough_in_plane = 6;
    int enough(int dimensions) const { return dimensions == 2 ? enough_in_plane : enough_neighbours; }

    double bulk = 10;           ///< lambda over mu: resistance to a change of volume within one step (the multiplier does the rest)
    double smoothing = 0.15;    ///< penalty on the residual of the linear fit, over mu: removes zero-energy modes
    double pair_smoothing = 5;  ///< the same along the pair only: keeps necks from growing without stiffening bending
    double thin_below = 0.8, thin_at = 0.6;  ///< middle over largest eigenvalue of M between which a thread turns thin (and is evened)

    double gate = 1.6;    ///< longer pairs count only with a common neighbour closer than `bridge` to both:
    double bridge = 1.7;  ///< turns of a coil must not feel each other through the air

    double push = 0.1;               ///< compressed particles part at the rate push (n/n0 - 1)/dt
    double no_surface = 0.0125;      ///< loose ones under pressure meet up to this Neighbourhood::surface; from twice this on no more
    double meeting_in_space = 0.15;  ///< in 3D they meet at this fraction of the rate (1 in 2D): at rest more are loose than compressed
    Index vessel = -1;  ///< round solid that turns the fluid about the vertical, -1: none. Then loose ones also meet next to surfaces
    double fastest_push =
        0.2;  ///< but not faster than this times (max |u| + sqrt(g d))/d: however short the step, they bring no motion of their own
    double memory = 0.98, weight_memory = 0.9999;  ///< from step to step, of the multiplier; of its part from 0 to the fluid's weight

    double shift_rate = 3, shift_range = 1.1, longest_shift = 0.1;  ///< repulsion of close particles: rate over |D|, range, bound a step
    double evening_rate = 1,
           evening_range = 2;  ///< along thin threads, where stretching widens every gap and no close particle can fill it

    /// Distances from a wall that the fluid sticks to: below the first a particle touches it, below the second, too, if one within `bridge`
    /// does; beyond the third it comes off. New particles touch up to there: a lattice may fill a gap loosely.
    double wall_touch = 0.55, wall_spread = 0.9, wall_reach = 1.6;
    double closest = 0.3;          ///< distance from a solid that the fluid sticks to, below which no particle goes
    double sliding_closest = 0.5;  ///< as `closest`, from a solid that it slides on: half a spacing is its share of the room there

    int aggregate = 48;          ///< particles in an aggregate of the coarse level
    int many = 5600;             ///< in fluids of n > many particles an aggregate has aggregate sqrt(n/many)
    int refresh_every = 5;       ///< steps between two set-ups of the coarse level
    bool diagonal = true;        ///< the diagonal blocks precondition; false: nothing does (to compare)
    int fewest_for_coarse = 32;  ///< free particles below which the diagonal alone preconditions
};

}  // namespace whorl
