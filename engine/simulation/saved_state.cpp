// The state of a run in a checkpoint.
#include <cmath>
#include <istream>
#include <ostream>
#include <utility>

#include "engine/core/binary_io.h"
#include "engine/models/viscosity/ageing_viscosity.h"
#include "engine/simulation/initial_state.h"
#include "engine/simulation/simulation_state.h"

namespace whorl {
namespace {

/// Refuses impossible values in a saved state, which could crash the run or prevent it from ending.
void must_be_sound(bool is_sound) {
    if (!is_sound) throw EnvironmentError("the saved state is not valid for this scene", "", "resume from an older checkpoint");
}

template <class T>
T take(std::istream& in) {
    T value{};
    if (!whorl::take(in, value)) throw EnvironmentError("the saved state ends too early", "", "resume from an older checkpoint");
    return value;
}
/// A count: at least 0.
template <>
long take(std::istream& in) {
    long value = 0;
    must_be_sound(!whorl::take(in, value) || (value >= 0 && value < 1L << 53));
    return in ? value : 0;
}
template <>
bool take(std::istream& in) {
    return take<char>(in) != 0;
}

std::streamoff bytes_left(std::istream& in) {
    const auto at = in.tellg();
    const auto end = in.seekg(0, std::ios::end).tellg();
    in.seekg(at);
    return end - at;
}

/// Calls f for each number of the totals, in the order of a saved state.
template <class Totals, class F>
void each_number(Totals& t, F&& f) {
    f(t.steps), f(t.particle_steps), f(t.pressure_iterations), f(t.viscosity_iterations);
    f(t.unconverged_solves), f(t.lost_particles), f(t.emitted_particles), f(t.drained_particles), f(t.last_step);
    f(t.work), f(t.any_work);
}

void put_columns(std::ostream& out, const ParticleStore& store) {
    put(out, store.size());
    for (const ParticleStore::Entry* entry : store.entries())
        if (entry->lasting)
            out.write(static_cast<const char*>(std::as_const(*entry->column).data()),
                      static_cast<std::streamsize>(entry->info->bytes * static_cast<std::size_t>(store.size())));
}

void take_columns(std::istream& in, ParticleStore& store) {
    const auto size = take<Index>(in);
    must_be_sound(size >= 0 && size <= bytes_left(in));
    store.resize(size);
    for (const ParticleStore::Entry* entry : store.entries())
        if (entry->lasting) {
            const auto bytes = static_cast<std::streamsize>(entry->info->bytes * static_cast<std::size_t>(size));
            if (!in.read(static_cast<char*>(entry->column->data()), bytes))
                throw EnvironmentError("the saved state ends too early", "", "resume from an older checkpoint");
        }
}

}  // namespace

void Simulation::save(std::ostream& out) const {
    const State& s = *state_;
    WHORL_ASSERT(s.steps_since_frame == 0, "save() between frame times");
    put(out, s.time), put(out, s.next_id);
    each_number(s.totals, [&](const auto& number) { put(out, number); });
    put(out, s.totals.binding.size());
    for (const auto& [limit, times] : s.totals.binding) {
        put(out, limit.size());
        out.write(limit.data(), static_cast<std::streamsize>(limit.size()));
        put(out, times);
    }
    put_columns(out, s.world.fluid), put_columns(out, s.world.ink_markers.store);
    for (const Emitter& emitter : s.emitters) emitter.save(out);
    for (const Solid& solid : s.world.solids.all)
        if (solid.body) solid.body->save(out);
}

void Simulation::load(std::istream& in) {
    State& s = *state_;
    s.time = take<double>(in), s.next_id = take<std::int32_t>(in);
    must_be_sound(std::isfinite(s.time) && s.time >= 0 && s.next_id >= 0);
    s.totals = {};
    each_number(s.totals, [&](auto& number) { number = take<std::remove_reference_t<decltype(number)>>(in); });
    for (auto limits = take<std::size_t>(in); limits > 0; --limits) {
        const auto length = take<std::size_t>(in);
        must_be_sound(length <= static_cast<std::size_t>(bytes_left(in)));
        std::string limit(length, ' ');
        in.read(limit.data(), static_cast<std::streamsize>(length));
        s.totals.binding[limit] = take<long>(in);
    }
    take_columns(in, s.world.fluid), take_columns(in, s.world.ink_markers.store);
    const auto emitters = static_cast<std::int16_t>(s.emitters.size());
    for (const std::int16_t role : s.world.fluid.column<field::role>()) must_be_sound(role >= -emitters);
    if (s.world.fluid.has<field::source>())
        for (const std::int16_t source : s.world.fluid.column<field::source>()) must_be_sound(source >= 0 && source <= emitters);
    for (Emitter& emitter : s.emitters) must_be_sound(emitter.load(in)), emitter.set_time(s.time);
    for (Solid& solid : s.world.solids.all)
        if (solid.body) must_be_sound(solid.body->load(in));
    if (!in) throw EnvironmentError("the saved state ends too early", "", "resume from an older checkpoint");
    s.steps_since_frame = 0;
    s.changed_wrongly = wrong_viscosity(s.world);  // the state may have been saved after a change but before a step that used it
    s.world.step.gravity = scene().domain.gravity(s.time).cast<Real>();
    s.world.step.time = s.time;
    s.world.solids.set_time(s.time, scene().time.look_ahead());
    s.world.boundary_particles.follow(s.world.solids);
}

}  // namespace whorl
