#pragma once
/// Runs of scenes that a test gives as text.
#include <stdexcept>
#include <string>

#include "engine/simulation/simulation.h"

namespace whorl::test {

/// @throws InputError if the text is not a valid scene, or the plan refuses it
Simulation simulation_of(const std::string& text);
/// Steps to `end` [s] and calls `each` after every step. @throws std::runtime_error if the run diverges
template <class F>
void run_until(Simulation& simulation, double end, const F& each) {
    for (; simulation.time() < end; each())
        if (simulation.step(end).diverged) throw std::runtime_error("the run diverged");
}
inline void run_until(Simulation& simulation, double end) {
    run_until(simulation, end, [] {});
}
/// The whole state that persists between steps, as bytes.
std::string state_of(const Simulation& simulation);
/// Empty if the state at `end` [s] has the same bits on 1 and 4 threads and in a run that was saved half-way; otherwise where it differs.
std::string differing_bits(const std::string& text, double end);

/// Positions [m], velocities [m/s] and pressures [Pa] of the fluid.
inline Span<const Vec3> positions(const Simulation& s) { return s.world().fluid.column<field::position>(); }
inline Span<const Vec3> velocities(const Simulation& s) { return s.world().fluid.column<field::velocity>(); }
inline Span<const Real> pressures(const Simulation& s) { return s.world().fluid.column<field::pressure>(); }
/// Mean of f(x, u) over the particles; x and u are Vec3d.
template <class F>
double mean_of(const Simulation& simulation, const F& f) {
    const auto x = positions(simulation), u = velocities(simulation);
    double sum = 0;
    for (std::size_t i = 0; i < x.size(); ++i) sum += f(Vec3d(x[i].cast<double>()), Vec3d(u[i].cast<double>()));
    return sum / static_cast<double>(x.size());
}
inline double mean_square_speed(const Simulation& simulation) {
    return mean_of(simulation, [](const Vec3d&, const Vec3d& u) { return u.squaredNorm(); });
}
/// The last solid, which is free.
inline const RigidBody& last_body(const Simulation& s) { return *s.world().solids.all.back().body; }

}  // namespace whorl::test
