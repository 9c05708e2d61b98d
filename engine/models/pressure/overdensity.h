#pragma once
/// Separates particles that a step compressed more than its linear solve predicted (docs/physics.md 3).
#include <functional>

#include "engine/models/pressure/density_rate.h"
#include "engine/particles/interaction_context.h"
#include "engine/particles/search.h"

namespace whorl {

/// The constraint limits rho_i + dt (D u)_i, with the rate of change of the density D u = d rho/dt (density_rate.h). If a particle hits a
/// wall or another particle within a step, its density rises far above this linear prediction. A sweep selects the particles denser than
/// rho_0 (1 + 0.9 most), and those of their neighbours denser than rho_0 (1 + most/2). It moves these particles and their surroundings,
///   x -= D^T l,   l_i = (rho_i - rho_0)/(2 (D D^T)_ii),   at most a fifth of a spacing,
/// with the densities rho_i and D at the current positions. Sweeps are repeated, at most a hundred times, until no density exceeds rho_0 (1
/// + 0.9 most). If particles are still too dense then, the step's report gets an entry of the kind `crowding` with a message.
///
/// If i is moved by a r_ij and j by -a r_ij (r_ij = x_i - x_j; a > 0: apart), their velocities change by -a and +a times the part of u_i -
/// u_j perpendicular to r_ij. The pair then turns more slowly, so angular momentum is conserved and kinetic energy does not grow. The
/// centre of mass moves only if solids push, or if displacements are cut at a fifth of a spacing.
///
/// The stage does nothing in full periodic domains. It also does nothing near bodies lighter than the fluid, and in scenes with free bodies
/// and without gravity, because the bodies would have to give way. Writes the densities at the end of the step.
class RelaxOverdensity {
public:
    /// @param most tolerated relative density error
    RelaxOverdensity(double most, SolidGate gate) : most_(static_cast<Real>(most)), gate_(gate) {}
    /// @param pairs, solid_pairs those of `context`; replaced by the neighbours at the end of the step, up to a fifth of a spacing beyond
    /// the kernel's support @param search finds them
    void operator()(const InteractionContext& context, FluidPairs& pairs, SolidPairs& solid_pairs, NeighbourSearch& search,
                    StepReport& report, Read<field::role> role, Update<field::density> rho, Update<field::position> x,
                    Update<field::velocity> u);

private:
    /// Temporary data of a step.
    struct Scratch {
        std::vector<Index> dense, crowded, movers, touched;
        std::vector<int> seen;  ///< by particle: the last list that it is in
        int lists = 0;
        Column<Vec3> push, moves, kicks;  ///< l_i own_i [m]; displacement of a mover [m]; change of its velocity [m/s]
        Column<Real> share;               ///< l_i f_i, 0 if not crowded. own_i, f_i: DensityRate
        explicit Scratch(Index n) : seen(n, 0), push(n), share(n, 0) {}
        /// The particles of `from` and their neighbours.
        void with_neighbours(const Pairs& pairs, const std::vector<Index>& from, std::vector<Index>& all);
    };
    /// @returns a message about particles that stay too dense; empty if there are none
    template <class Kernel>
    std::string relieve(const WallImage& wall, const Kernel& W, const InteractionContext& context, Read<field::role> role, Span<Real> rho,
                        Span<Vec3> x, Span<Vec3> u, const std::function<void()>& find) const;

    Real most_;
    SolidGate gate_;
};

}  // namespace whorl
