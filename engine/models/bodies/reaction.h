#pragma once
/// Ledger entries: the opposite of the solids' forces on the fluid (docs/physics.md 7), and of changes without a force: a solver's
/// residual, gradients that are not pairwise opposite.
#include <vector>

#include "engine/core/parallel.h"
#include "engine/particles/field.h"
#include "engine/particles/interaction_context.h"

namespace whorl {

/// The particles that have a neighbour in the layer of solid k, in order.
std::vector<Index> particles_at(const InteractionContext& context, std::size_t k);
/// In that of any free body.
std::vector<Index> particles_at_bodies(const InteractionContext& context);

/// Solids whose ledger a stage writes: all, or those that are not unknowns of its solve.
enum class Writes { all, driven };

/// Change of a particle's velocity by a solid particle, and where the opposite acts on the solid: `back` [m] from there to the particle.
struct PushAt {
    Vec3 push, back = Vec3::Zero();
    PushAt(const Vec3& p) : push(p) {}  // NOLINT(google-explicit-constructor): most push where the particle is
    PushAt(const Vec3& p, const Vec3& b) : push(p), back(b) {}
};

/// Writes to the ledgers the opposite of the layers' forces on the particles. It acts where the particle is (unless `act` says
/// otherwise): whatever the direction of the force, momentum and angular momentum of both together are conserved.
/// @param scale mass [kg], times dt [s] if `act` gives accelerations
/// @param act i -> (s, r, distance) -> change of the velocity of particle i by solid particle s: Vec3 or PushAt
template <class Act>
void react(const InteractionContext& context, Push kind, Read<field::role> role, Real scale, const Act& act, Writes writes = Writes::all) {
    for (std::size_t k = 0; k < context.solids.all.size(); ++k) {
        Solid& solid = context.solids.all[k];
        if (!solid.keeps_ledger() || (writes == Writes::driven && solid.body)) continue;
        const std::vector<Index> near = particles_at(context, k);
        const Vec3d centre = solid.centre();
        const auto each = [&](Index i, const auto& f) {
            if (role[i] != 0) return;
            const auto& on_i = act(i);
            context.solid_pairs.of(i, [&](Index s, const Vec3& r, Real distance) {
                if (static_cast<std::size_t>(context.boundary.solid[s]) != k) return;
                const PushAt on = on_i(s, r, distance);
                f(s, (context.boundary.position[s] + r - on.back).template cast<double>() - centre,
                  Vec3d(-on.push.template cast<double>()));
            });
        };
        const Wrench sum = parallel_sum(static_cast<Index>(near.size()), Wrench{}, [&](Index e) {
            Wrench one;
            each(near[e], [&](Index, const Vec3d& arm, const Vec3d& push) { one += Wrench::at(arm, push); });
            return one;
        });
        solid.receive(kind, static_cast<double>(scale) * sum);
        if (kind == Push::viscous || context.boundary.pressed.empty()) continue;
        for (const Index i : near)
            each(i, [&](Index s, const Vec3d&, const Vec3d& push) { context.boundary.pressed[s] += static_cast<double>(scale) * push; });
    }
}

/// Momentum and angular momentum about the origin, over a particle's mass, of changes of the free particles' velocities.
/// @param change i -> [m/s]
template <class Change>
Wrench momentum_of(Read<field::role> role, Span<const Vec3> x, const Change& change) {
    return parallel_sum(static_cast<Index>(x.size()), Wrench{}, [&](Index i) {
        return role[i] == 0 ? Wrench::at(x[i].cast<double>(), Vec3d(change(i).template cast<double>())) : Wrench{};
    });
}

/// Made before a stage writes its forces of one kind to the ledgers. share() gives the remainder to the driven solids in proportion to the
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

/// Inner forces that are not pairwise opposite (of the projection, of images). What they change of the fluid's momentum goes to the driven
/// solids, unless fluid in a nozzle has a part in it.
/// @param change i -> change of the velocity since `rest` was made [m/s]
template <class Change>
void share_rest(const Remainder& rest, const InteractionContext& context, Read<field::role> role, Span<const Vec3> x, const Change& change,
                const std::vector<std::size_t>& exact = {}) {
    if (!context.solids.any_probed() || parallel_sum(role.size(), [&](Index i) { return role[i] != 0; }) > 0) return;
    const Wrench gained = static_cast<double>(context.step.mass) * momentum_of(role, x, change);
    rest.share(context.solids, context.step, -1 * (gained + rest.received(context.solids)), exact);
}

}  // namespace whorl
