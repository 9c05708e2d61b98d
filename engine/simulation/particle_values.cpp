// Viscosity, temperature, colours and ids of particles that enter, and of all particles after a live change.
#include <fmt/format.h>

#include <bit>
#include <cmath>

#include "engine/core/random.h"
#include "engine/models/viscosity/ageing_viscosity.h"
#include "engine/scene/tree.h"
#include "engine/simulation/initial_state.h"

namespace whorl {
namespace {

/// The column, empty if the store does not have it.
template <class F>
Span<typename F::type> column_or_none(ParticleStore& fluid) {
    return fluid.has<F>() ? fluid.column<F>() : Span<typename F::type>();
}

Divergence no_viscosity(const World& world, const std::string& key, double value, const Vec3& x) {
    return {"new fluid", "viscosity", world.step.time, x.cast<double>(), fmt::format("{} is {:.4g} Pa s", key, value)};
}

}  // namespace

std::optional<Divergence> set_viscosity(const Scene& scene, World& world, Index first, int source) {
    ParticleStore& fluid = world.fluid;
    const auto x = fluid.column<field::position>();
    const auto from = static_cast<std::size_t>(first);
    std::optional<Divergence> wrong;
    if (fluid.has<field::viscosity>()) {
        const Expression& expression = scene.viscosity_of_source(source);
        const auto mu = fluid.column<field::viscosity>();
        const auto T = column_or_none<field::temperature>(fluid);
        for (std::size_t i = from; i < mu.size(); ++i) {
            const double value = expression(0, x[i].cast<double>(), T.empty() ? 0 : static_cast<double>(T[i]));
            mu[i] = static_cast<Real>(value);
            if (is_viscosity(value) || wrong) continue;
            const bool own = source > 0 && scene.emitters[static_cast<std::size_t>(source) - 1].viscosity;
            wrong = no_viscosity(world, (own ? entry_name("emitter", static_cast<std::size_t>(source) - 1) : "fluid") + ".viscosity", value,
                                 x[i]);
        }
    }
    if (fluid.has<field::source>())
        for (std::int16_t& s : fluid.column<field::source>().subspan(from)) s = static_cast<std::int16_t>(source);
    if (fluid.has<field::birthplace>()) std::copy(x.begin() + first, x.end(), fluid.column<field::birthplace>().begin() + first);
    return wrong;
}

std::optional<Divergence> set_temperature(const Scene& scene, World& world, Index first, int source, std::size_t block, double time) {
    if (!world.fluid.has<field::temperature>()) return {};
    const auto x = world.fluid.column<field::position>();
    const auto T = world.fluid.column<field::temperature>();
    std::optional<Divergence> wrong;
    for (auto i = static_cast<std::size_t>(first); i < T.size(); ++i) {
        const Vec3d at = x[i].cast<double>();
        const double value = scene.start_temperature(static_cast<std::size_t>(source), at, block, time);
        T[i] = static_cast<Real>(value);
        if (!(value > 0 && std::isfinite(value)) && !wrong) {
            const std::string name = source > 0 ? entry_name("emitter", static_cast<std::size_t>(source) - 1) : entry_name("block", block);
            wrong = Divergence{"new fluid", "temperature", time, at, fmt::format("{}.temperature is {:.4g} K", name, value)};
        }
    }
    return wrong;
}

std::optional<Divergence> set_colours(const Scene& scene, World& world, Index first, const Inks& inks, const std::string& key,
                                      double time) {
    ParticleStore& fluid = world.fluid;
    const auto x = fluid.column<field::position>();
    const auto from = static_cast<std::size_t>(first);
    std::optional<Divergence> wrong;
    if (fluid.has<field::ink>()) {
        const VectorExpression concentration = inks.vector();
        const auto colour = [&](Span<const Vec3> places, Span<Vec3> ink) {
            for (std::size_t i = 0; i < ink.size(); ++i) {
                const Vec3d at = places[i].cast<double>(), c = concentration(time, at);
                ink[i] = c.cwiseMax(0.0).cwiseMin(1.0).cast<Real>();
                if (c.hasNaN() && !wrong) wrong = Divergence{"new fluid", "ink", time, at, key + " is not a number"};
            }
        };
        colour(x.subspan(from), fluid.column<field::ink>().subspan(from));
        if (InkMarkers& markers = world.ink_markers; markers.per_spacing > 0) {
            std::copy(x.begin() + first, x.end(), fluid.column<field::path_start>().begin() + first);
            const auto added = static_cast<std::size_t>(markers.add(x.subspan(from), world.step));
            colour(markers.store.column<field::position>().subspan(added), markers.store.column<field::ink>().subspan(added));
        }
    }
    if (!fluid.has<field::grain>()) return wrong;
    const auto grain = fluid.column<field::grain>();
    RandomNumbers random(scene.seed ^ std::bit_cast<std::uint64_t>(time) ^ static_cast<std::uint64_t>(first));
    for (std::size_t i = from; i < grain.size(); ++i) grain[i] = static_cast<Real>(random());
    return wrong;
}

void set_ids(World& world, Index first, std::int32_t& next) {
    if (!world.fluid.has<field::id>()) return;
    for (std::int32_t& id : world.fluid.column<field::id>().subspan(static_cast<std::size_t>(first))) id = next++;
}

std::optional<Divergence> change_viscosity(const Scene& scene, World& world) {
    ParticleStore& fluid = world.fluid;
    std::optional<Divergence> wrong;
    if (!fluid.has<field::viscosity>()) return wrong;
    const auto x = fluid.column<field::position>();
    const auto mu = fluid.column<field::viscosity>();
    const auto source = column_or_none<field::source>(fluid);
    const auto age = column_or_none<field::age>(fluid);
    const auto birthplace = column_or_none<field::birthplace>(fluid);
    const auto T = column_or_none<field::temperature>(fluid);
    for (std::size_t i = 0; i < mu.size(); ++i) {
        const std::size_t from = source.empty() ? 0 : static_cast<std::size_t>(source[i]);
        if (from > 0 && scene.emitters[from - 1].viscosity) continue;
        const double value = scene.fluid.viscosity(age.empty() ? 0 : static_cast<double>(age[i]), x[i].cast<double>(),
                                                   T.empty() ? 0 : static_cast<double>(T[i]));
        mu[i] = static_cast<Real>(value);
        if (!is_viscosity(value) && !wrong) wrong = no_viscosity(world, "fluid.viscosity", value, x[i]);
        if (!birthplace.empty()) birthplace[i] = x[i];
    }
    return wrong;
}

std::optional<Divergence> wrong_viscosity(const World& world) {
    const ParticleStore::Entry* const entry = world.fluid.find(field::viscosity::name);
    if (entry == nullptr || !entry->lasting) return {};
    const auto mu = world.fluid.column<field::viscosity>();
    for (std::size_t i = 0; i < mu.size(); ++i)
        if (const auto value = static_cast<double>(mu[i]); !is_viscosity(value))
            return no_viscosity(world, "fluid.viscosity", value, world.fluid.column<field::position>()[i]);
    return {};
}

}  // namespace whorl
