#pragma once
/// Momentum that the solids' forces of a stage do not account for: a solver's residual, gradients that are not pairwise opposite.
#include <vector>

#include "engine/core/parallel.h"
#include "engine/particles/field.h"
#include "engine/particles/surroundings.h"

namespace whorl {

/// Made before a stage writes its forces of one kind to the ledgers; share() then gives the driven solids what the fluid gained and they do
/// not account for, in proportion to the impulses that they received since. So the sum over all solids is the opposite of the fluid's
/// change, whatever the stage leaves out. Without a driven solid in touch, nothing. Angular momentum: not in periodic domains, where it
/// depends on the origin.
class Remainder {
public:
    Remainder() = default;
    Remainder(const Solids& solids, Push kind);
    /// @param exact solids that have a part only if no other is in touch @param change of a particle's velocity since [m/s]
    template <class Change>
    void share(const Surroundings& around, Read<field::role> role, Span<const Vec3> x, const std::vector<std::size_t>& exact,
               const Change& change) const {
        if (before_.empty()) return;
        share(around, exact, parallel_sum(static_cast<Index>(x.size()), Wrench{}, [&](Index i) {
                  return role[i] == 0 ? Wrench::at(x[i].cast<double>(), Vec3d(change(i).template cast<double>())) : Wrench{};
              }));
    }

private:
    /// @param gained momentum of the fluid over a particle's mass, and angular momentum about the origin
    void share(const Surroundings& around, const std::vector<std::size_t>& exact, const Wrench& gained) const;

    Push kind_ = Push::pressure;
    std::vector<Wrench> before_;  ///< by solid; empty: no probe reads a ledger
};

}  // namespace whorl
