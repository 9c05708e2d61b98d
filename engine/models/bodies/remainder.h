#pragma once
/// Momentum that the forces of a stage do not account for: a solver's residual, gradients that are not pairwise opposite.
#include <vector>

#include "engine/core/parallel.h"
#include "engine/particles/field.h"
#include "engine/particles/surroundings.h"

namespace whorl {

/// Momentum and angular momentum about the origin, over a particle's mass, of changes of the free particles' velocities.
/// @param change i -> [m/s]
template <class Change>
Wrench momentum_of(Read<field::role> role, Span<const Vec3> x, const Change& change) {
    return parallel_sum(static_cast<Index>(x.size()), Wrench{}, [&](Index i) {
        return role[i] == 0 ? Wrench::at(x[i].cast<double>(), Vec3d(change(i).template cast<double>())) : Wrench{};
    });
}

/// Made before a stage writes its forces of one kind to the ledgers. share() gives what is left to the driven solids in proportion to the
/// impulses that they have received since, so that the sum over all solids is the opposite of the fluid's change. If no driven solid is in
/// touch, nothing. Angular momentum: not in periodic domains, where it depends on the origin.
class Remainder {
public:
    Remainder() = default;
    Remainder(const Solids& solids, Push kind);
    /// By all solids since, about the origin.
    Wrench received(const Solids& solids) const;
    /// @param rest impulse on the solids, about the origin @param exact solids that have a part only if no other is in touch
    void share(Solids& solids, const StepContext& step, const Wrench& rest, const std::vector<std::size_t>& exact = {}) const;

private:
    Wrench received(const Solids& solids, std::size_t k) const { return solids.all[k].ledger[kind_] + -1 * before_[k]; }

    Push kind_ = Push::pressure;
    std::vector<Wrench> before_;  ///< by solid
};

}  // namespace whorl
