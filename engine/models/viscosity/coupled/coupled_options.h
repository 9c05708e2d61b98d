#pragma once
/// Options of the coupled solve. Lengths in spacings d.
#include <algorithm>

#include "engine/core/types.h"
#include "engine/math/solve.h"

namespace whorl {

struct CoupledOptions {
    /// Tolerance for sqrt(r.M r) / sqrt(b.M b), with r the residual, b the right-hand side and M the preconditioner. This ratio follows the
    /// error of the velocity. 3e-3 suffices for coils, stretched threads need 1e-3. The tolerance applies to steps in which the fastest
    /// fluid moves by 0.4 d. In shorter steps it is proportionally smaller.
    SolveLimits limits{1e-3, 300};

    double support = 2.4, widest_support = 4;  ///< kernel radius; it grows until a particle has enough() neighbours
    double widest() const { return std::max(support, widest_support); }
    int enough_neighbours = 16, enough_in_plane = 6;
    int enough(int dimensions) const { return dimensions == 2 ? enough_in_plane : enough_neighbours; }

    double bulk = 10;           ///< lambda/mu: resistance to a change of volume within one step; the multiplier removes the rest
    double smoothing = 0.15;    ///< (penalty on the residual of the linear fit)/mu; removes zero-energy modes
    double pair_smoothing = 5;  ///< the same along pairs only; keeps necks from growing and does not stiffen bending
    /// Ratios of the middle to the largest eigenvalue of M. Above the first a thread is thick, below the second thin (evened).
    double thin_below = 0.8, thin_at = 0.6;

    double gate = 1.6;    ///< longer pairs interact only if a third particle is closer than `bridge` to both,
    double bridge = 1.7;  ///< so that turns of a coil do not interact through the air

    double push = 0.1;  ///< compressed particles separate at the rate push (n/n0 - 1)/dt
    /// Loose particles under pressure approach if Neighbourhood::surface is below this. From twice this value on none do.
    double no_surface = 0.0125;
    /// Factor on the rate of loose particles in 3D (1 in 2D), because at rest more particles are loose than compressed.
    double meeting_in_space = 0.25;
    /// Round solid that turns the fluid about the vertical, -1: none. With a vessel, loose particles at surfaces also approach, at a rate
    /// that uses Neighbourhood::surface up to even_surface. The surface of a lattice has 0.31, a particle on top of a surface 0.6.
    Index vessel = -1;
    double even_surface = 0.34;
    /// Limit of these rates, in units of (max |u| + sqrt(g d))/d. Without it the rates of short steps would set the fluid in motion.
    double fastest_push = 0.2;
    /// Limit of these rates in fluid with a yield stress, over its shear rate in the last step. A body that is rigid is then not pushed.
    /// With a bulk viscosity of 10 tau_y/g_0 the push would make it yield in every step, and give it energy.
    double push_of_shear = 0.1;
    /// Limit of the bulk viscosity in fluid with a yield stress, over bulk rho d^2/dt. With more, rigid fluid needs more iterations.
    double rigid_bulk = 1000;
    /// Least bulk viscosity in fluid with a yield stress, over bulk rho d^2/dt. With less, fluid that flows thinly compresses by a tenth as
    /// it collapses, and bursts.
    double least_bulk = 1;
    /// Limit of the apparent viscosity of a particle with a yield stress, over the smallest among its neighbours. Stress is continuous, so
    /// a rigid particle next to flowing fluid creeps at 1/1000 of the fluid's shear rate. Without the limit the rows of rigid particles
    /// that reach into molten fluid give the solve eigenvalues of all sizes: a block of 800 Pa that melts to 0.5 Pa s needs up to 660
    /// iterations per step instead of 200.
    double steepest_jump = 1000;
    /// Factors per step on the multiplier, and on the part of it from 0 to the fluid's weight.
    double memory = 0.98, weight_memory = 0.9999;

    double shift_rate = 3, shift_range = 1.1,
           longest_shift = 0.1;  ///< repulsion of close particles: rate over |D|, range, largest displacement per step
    /// Strain rate that this repulsion adds to |D| under weight, in units of min(p, rho g d)/mu.
    double weight_strain = 0.01;
    double evening_rate = 1,
           evening_range = 2;  ///< the same along thin threads, in which no close particle fills the gaps that stretching widens

    /// Distances from a wall. Below wall_touch a particle touches the wall. Below wall_spread it also does if a particle within `bridge`
    /// touches and the fluid sticks. Beyond wall_reach it detaches. New particles touch up to wall_reach, because a lattice may fill a gap
    /// loosely.
    double wall_touch = 0.55, wall_spread = 0.9, wall_reach = 1.6;
    double closest = 0.3;  ///< least distance of a particle from a solid
    /// Part by which a wall counts less for a particle that other walls hold too, over the fraction of the kernel behind those.
    double edge_share = 0.65;

    int aggregate = 48;          ///< particles in an aggregate of the coarse level
    int many = 5600;             ///< in fluids of n > many particles an aggregate has `aggregate` sqrt(n/many)
    int refresh_every = 5;       ///< steps between two set-ups of the coarse level
    bool diagonal = true;        ///< precondition with the diagonal blocks; false: no preconditioner (for comparison)
    int fewest_for_coarse = 32;  ///< number of free particles below which the diagonal alone preconditions
};

}  // namespace whorl
