#pragma once
/// Ledger entries of solids (docs/physics.md 7). They are the opposite of the solids' forces on the fluid, and of changes of the fluid's
/// momentum without a force (from a solver's residual, or from gradients that are not pairwise opposite).
#include <vector>

#include "engine/core/parallel.h"
#include "engine/particles/field.h"
#include "engine/particles/interaction_context.h"

namespace whorl {

/// Particles that have a boundary particle of solid k as a neighbour, in order.
std::vector<Index> particles_at(const InteractionContext& context, std::size_t k);
/// Particles that have a boundary particle of any free body as a neighbour, in order.
std::vector<Index> particles_at_bodies(const InteractionContext& context);

/// Solids whose ledger a stage writes: all solids, or those that are not unknowns of the stage's solve.
enum class Writes { all, driven };

/// Change of a particle's velocity by a boundary particle, and the point of the solid on which the opposite impulse acts.
struct PushAt {
    Vec3 push, back = Vec3::Zero();     ///< m/s; from that point to the particle [m]
    PushAt(const Vec3& p) : push(p) {}  // NOLINT(google-explicit-constructor): most reactions act at the particle
    PushAt(const Vec3& p, const Vec3& b) : push(p), back(b) {}
};

/// Writes to the ledgers the opposite of the forces of boundary particles on fluid particles. Unless `act` gives another point, this
/// opposite acts at the position of the fluid particle, so momentum and angular momentum of fluid and solids are conserved for any
/// direction of the force.
/// @param scale mass [kg], times dt [s] if `act` gives accelerations
/// @param act i -> (s, r, distance) -> change of the velocity of particle i by boundary particle s: Vec3 or PushAt
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

/// Momentum and angular momentum about the origin, per particle mass, of changes of the free particles' velocities.
/// @param change i -> [m/s]
template <class Change>
Wrench momentum_of(Read<field::role> role, Span<const Vec3> x, const Change& change) {
    return parallel_sum(static_cast<Index>(x.size()), Wrench{}, [&](Index i) {
        return role[i] == 0 ? Wrench::at(x[i].cast<double>(), Vec3d(change(i).template cast<double>())) : Wrench{};
    });
}

/// Distributes the part of the fluid's momentum change that no force accounts for. Construct a Remainder before a stage writes its forces
/// of one kind to the ledgers. share() then gives the remainder to the driven solids, in proportion to the impulses that they have received
/// since the construction. The sum over all solids is then the opposite of the fluid's change. If no driven solid touches the fluid,
/// share() does nothing. In periodic domains angular momentum is left out, because it depends on the origin.
class Remainder {
public:
    Remainder() = default;
    Remainder(const Solids& solids, Push kind);
    /// Impulse that all solids have received since the construction, about the origin.
    Wrench received(const Solids& solids) const;
    /// @param rest impulse to distribute, about the origin @param exact solids that receive a part only if no other solid touches the fluid
    void share(Solids& solids, const StepContext& step, const Wrench& rest, const std::vector<std::size_t>& exact = {}) const;

private:
    Wrench received(const Solids& solids, std::size_t k) const { return solids.all[k].ledger[kind_] + -1 * before_[k]; }

    Push kind_ = Push::pressure;
    std::vector<Wrench> before_;  ///< by solid
};

/// For internal forces that are not pairwise opposite (in the projection, or of images). Gives the change of the fluid's momentum by these
/// forces to the driven solids. Does nothing if any particle is in a nozzle, because a part belongs to the nozzle.
/// @param change i -> change of the velocity since `rest` was constructed [m/s]
template <class Change>
void share_rest(const Remainder& rest, const InteractionContext& context, Read<field::role> role, Span<const Vec3> x, const Change& change,
                const std::vector<std::size_t>& exact = {}) {
    if (!context.solids.any_probed() || parallel_sum(role.size(), [&](Index i) { return role[i] != 0; }) > 0) return;
    const Wrench gained = static_cast<double>(context.step.mass) * momentum_of(role, x, change);
    rest.share(context.solids, context.step, -1 * (gained + rest.received(context.solids)), exact);
}

}  // namespace whorl
