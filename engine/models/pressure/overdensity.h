#pragma once
/// Separates particles that a step compressed more than its linear solve predicted (docs/physics.md 3).
#include <functional>

#include "engine/models/pressure/density_rate.h"
#include "engine/particles/interaction_context.h"
#include "engine/particles/search.h"

namespace whorl {

/// The constraint holds rho_i + dt (D u)_i; where a particle hits a wall or another one within a step, the density itself has gone far
/// beyond that line. While any density exceeds rho_0 by `most`, those that do, and their neighbours that exceed it by half of that share,
/// move their surroundings and themselves,
///   x -= D^T l,   l_i = (rho_i - rho_0)/(2 (D D^T)_ii),   at most a fifth of a spacing,
/// with the densities and their derivative of the positions reached. Two that are moved apart turn about each other as much more slowly: a
/// pair that moves by -a r_ij and a r_ij takes +a and -a of its relative velocity across r_ij, so that the angular momentum stays and no
/// energy of motion is gained; the centre of mass is fixed except for pushes by solids and moves that are cut off. Up to a hundred
/// sweeps; if they are not enough, the step reports a solve of the kind `crowding` that says so. Full periodic domains
/// are left alone, and so are particles near bodies lighter than the fluid, and scenes with bodies and without weight: there the bodies
/// would have to give way. Writes the densities
/// of the places where the step ends.
class RelaxOverdensity {
public:
    /// @param most relative density error that is left
    RelaxOverdensity(double most, SolidGate gate) : most_(static_cast<Real>(most)), gate_(gate) {}
    /// @param pairs, solid_pairs those of `context`, which become the neighbours of the places where the step ends, found with `search` a
    /// fifth of a spacing farther than the models need
    void operator()(const InteractionContext& context, FluidPairs& pairs, SolidPairs& solid_pairs, NeighbourSearch& search,
                    StepReport& report, Read<field::role> role, Update<field::density> rho, Update<field::position> x,
                    Update<field::velocity> u);

private:
    /// Temporary data of a step.
    struct Scratch {
        std::vector<Index> dense, crowded, movers, touched;
        std::vector<int> seen;  ///< by particle: the last list that it is in
        int lists = 0;
        Column<Vec3> push, moves, kicks;  ///< l_i own_i; a mover's displacement [m] and velocity change [m/s]
        Column<Real> share;               ///< l_i f_i, 0 if not crowded
        explicit Scratch(Index n) : seen(n, 0), push(n), share(n, 0) {}
        /// The particles of `from` and their neighbours.
        void with_neighbours(const Pairs& pairs, const std::vector<Index>& from, std::vector<Index>& all);
    };
    /// @returns a text about particles that stay too dense; empty: none
    template <class Kernel>
    std::string relieve(const WallImage& wall, const Kernel& W, const InteractionContext& context, Read<field::role> role, Span<Real> rho,
                        Span<Vec3> x, Span<Vec3> u, const std::function<void()>& find) const;

    Real most_;
    SolidGate gate_;
};

}  // namespace whorl
