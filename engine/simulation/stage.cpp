#include "engine/simulation/stage.h"

#include <cmath>
#include <set>

#include "engine/core/parallel.h"

namespace whorl {

void declare_fields(const std::vector<Stage>& stages, ParticleStore& store) {
    std::set<const FieldInfo*> written;
    for (const Stage& stage : stages)
        for (const FieldAccess& a : stage.accesses) {
            store.declare(*a.field, a.access != Access::write && written.count(a.field) == 0);
            if (a.access != Access::read) written.insert(a.field);
        }
}

namespace {

/// The lowest index with a non-finite value, -1 if there is none.
Index first_not_finite(const Real* values, int components, Index n) {
    const auto wrong = [](Real v) { return !std::isfinite(v); };
    if (parallel_sum(n * components, [=](Index k) { return wrong(values[k]) ? 1.0 : 0.0; }) == 0) return -1;
    return static_cast<Index>(std::find_if(values, values + std::ptrdiff_t(n) * components, wrong) - values) / components;
}

}  // namespace

std::optional<Divergence> find_divergence(const Stage& stage, const World& world) {
    for (const FieldAccess& a : stage.accesses) {
        if (a.access == Access::read || a.field->integer) continue;
        const ParticleStore::Entry* entry = world.fluid.find(a.field->name);
        if (!entry->lasting) continue;  // scratch values that matter end up in a lasting field
        const Real* values = static_cast<const Real*>(std::as_const(*entry->column).data());
        const Index i = first_not_finite(values, a.field->components, world.fluid.size());
        if (i < 0) continue;
        const Vec3 x = world.fluid.column<field::position>()[i];
        return Divergence{stage.name, std::string(a.field->name), world.step.time, x.cast<double>(),
                          std::string(a.field->name) + " is not finite"};
    }
    return std::nullopt;
}

std::optional<Divergence> find_divergent_body(const Stage& stage, const World& world) {
    for (std::size_t k = 0; k < world.solids.all.size(); ++k) {
        const auto& body = world.solids.all[k].body;
        if (!body ||
            (body->centre.allFinite() && body->velocity.allFinite() && body->spin_momentum.allFinite() && body->turn.coeffs().allFinite()))
            continue;
        return Divergence{stage.name, "velocity", world.step.time, body->centre,
                          "the motion of solid[" + std::to_string(k) + "] is not finite"};
    }
    return std::nullopt;
}

}  // namespace whorl
