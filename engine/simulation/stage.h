#pragma once
/// Stages of a step. Each is a struct whose operator() has the fields that it reads and writes as arguments. make_stage() converts such a
/// struct into a form that the step loop can run and the plan can print.
#include <algorithm>
#include <functional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "engine/simulation/world.h"

namespace whorl {

enum class Access { read, write, update };

struct FieldAccess {
    const FieldInfo* field;
    Access access;
};

struct Stage {
    std::string name;   ///< "density", "full viscosity"
    std::string group;  ///< entry of run.json that gets its time: neighbours | density | viscosity | pressure | move | ...
    std::vector<FieldAccess> accesses;
    std::function<void(World&)> run = {};
    double EnergyBudget::*cause = nullptr;  ///< entry of the budget for the energy that the stage adds or removes; null: not counted
    double share = 1;                       ///< fraction of the stage's change of kinetic energy that counts for the cause
    bool writes(const FieldInfo& field) const {
        return std::any_of(accesses.begin(), accesses.end(),
                           [&](const FieldAccess& a) { return a.field == &field && a.access != Access::read; });
    }
};

namespace detail {

template <class T>
struct Argument;  // a compiler's "undefined" here means: an operator() has an argument that World does not contain

template <class F>
struct Argument<Read<F>> {
    static void list(std::vector<FieldAccess>& all) { all.push_back({&field_info<F>(), Access::read}); }
    static Read<F> get(World& w) { return {std::as_const(w.fluid).template column<F>()}; }
};
template <class F>
struct Argument<Write<F>> {
    static void list(std::vector<FieldAccess>& all) { all.push_back({&field_info<F>(), Access::write}); }
    static Write<F> get(World& w) { return {w.fluid.template column<F>()}; }
};
template <class F>
struct Argument<Update<F>> {
    static void list(std::vector<FieldAccess>& all) { all.push_back({&field_info<F>(), Access::update}); }
    static Update<F> get(World& w) { return {{w.fluid.template column<F>()}}; }
};

#define WHORL_SHARED_ARGUMENT(Type, member)                        \
    template <>                                                    \
    struct Argument<Type> {                                        \
        static void list(std::vector<FieldAccess>&) {}             \
        static decltype(auto) get(World& w) { return (w.member); } \
    };
WHORL_SHARED_ARGUMENT(const InteractionContext&, context())
WHORL_SHARED_ARGUMENT(FluidPairs&, fluid_pairs)
WHORL_SHARED_ARGUMENT(SolidPairs&, solid_pairs)
WHORL_SHARED_ARGUMENT(NeighbourSearch&, search)
WHORL_SHARED_ARGUMENT(InkMarkers&, ink_markers)
WHORL_SHARED_ARGUMENT(const Solids&, solids)
WHORL_SHARED_ARGUMENT(Solids&, solids)
WHORL_SHARED_ARGUMENT(const StepContext&, step)
WHORL_SHARED_ARGUMENT(StepReport&, report)
#undef WHORL_SHARED_ARGUMENT

template <class S, class R, class... A>
void list_arguments(R (S::*)(A...), std::vector<FieldAccess>& all) {
    (Argument<A>::list(all), ...);
}
template <class S, class R, class... A>
void list_arguments(R (S::*)(A...) const, std::vector<FieldAccess>& all) {
    (Argument<A>::list(all), ...);
}
template <class S, class R, class... A>
void run_with(R (S::*)(A...), S& stage, World& w) {
    stage(Argument<A>::get(w)...);
}
template <class S, class R, class... A>
void run_with(R (S::*)(A...) const, S& stage, World& w) {
    stage(Argument<A>::get(w)...);
}

}  // namespace detail

template <class S>
Stage make_stage(std::string name, std::string group, S stage) {
    Stage made;
    made.name = std::move(name), made.group = std::move(group);
    detail::list_arguments(&S::operator(), made.accesses);
    auto shared = std::make_shared<S>(std::move(stage));
    made.run = [shared](World& w) { detail::run_with(&S::operator(), *shared, w); };
    return made;
}

/// Declares the fields that a step needs. A field that a stage reads or updates before any stage has written it is lasting: its values
/// are kept between steps.
void declare_fields(const std::vector<Stage>& stages, ParticleStore& store);

/// The first particle (lowest index) with a non-finite value in a lasting field that the stage wrote; empty if there is none.
std::optional<Divergence> find_divergence(const Stage& stage, const World& world);
/// The first free body with a non-finite state; empty if there is none.
std::optional<Divergence> find_divergent_body(const Stage& stage, const World& world);

}  // namespace whorl
