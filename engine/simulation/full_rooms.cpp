// Rooms that emitters fill, and fluid that exceeds the available room.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "engine/core/parallel.h"
#include "engine/simulation/simulation_state.h"

namespace whorl {

/// Measures how many particles still fit into each closed room when the run begins.
void Simulation::State::measure_rooms() {
    constexpr double densest = 0.97;  // fluid that has flowed in is less dense than a lattice
    const auto x = world.fluid.column<field::position>();
    const auto role = world.fluid.column<field::role>();
    for (const ClosedRoom& room : plan.rooms) {
        const double there =
            parallel_sum(world.fluid.size(), [&](Index i) { return role[i] >= 0 && room.box.contains(x[i].cast<double>()) ? 1.0 : 0.0; });
        // The bounding box of the room may also contain other fluid, hence the upper limit.
        room_left.push_back((densest * room.volume - std::min(there * plan.particle_volume(), 1.2 * room.fluid)) / plan.particle_volume());
    }
}

/// Closes the emitters of a full room, because they would compress its fluid.
void Simulation::State::close_full_rooms() {
    for (std::size_t k = 0; k < std::min(room_left.size(), plan.rooms.size()); ++k) {
        const ClosedRoom& room = plan.rooms[k];
        double come = 0;
        for (const std::size_t e : room.emitters) come += emitters[e].expected_particles();
        if (come < room_left[k]) continue;
        for (const std::size_t e : room.emitters) emitters[e].close(time);
        const double more = room.coming / plan.particle_volume() - come;
        if (more < 1 || std::exchange(room_left[k], 0) == 0) continue;
        world.report.full =
            fmt::format("{} is full at {:.4g} s: nothing more enters from {}; {:.3g} m^{} more ({:.0f} particles) would come until the end",
                        room.text(), time, room.names(), more * plan.particle_volume(), plan.dimensions(), more);
    }
}

/// Warning with the location and amount of fluid that exceeds the available room. Empty unless more than a tenth of the particles are
/// more than 5 % too dense, whatever the cause (blocks, an emitter or a lid).
std::string Simulation::State::overfull() const {
    constexpr double much = 1.05, few = 0.1;
    const bool splashes = plan.traits.pressure.source == PressureSource::velocity && plan.free_surface;
    if (!world.fluid.has<field::density>() || splashes) return "";
    const auto x = world.fluid.column<field::position>();
    const auto role = world.fluid.column<field::role>();
    const auto rho = world.fluid.column<field::density>();
    const double rho_0 = static_cast<double>(world.step.rest_density);
    const auto excess = [&](Index i) { return role[i] == 0 ? static_cast<double>(rho[i]) / rho_0 - 1 : 0; };
    const auto dense = [&](Index i) { return excess(i) > much - 1; };
    const double count = parallel_sum(world.fluid.size(), [&](Index i) { return dense(i) ? 1.0 : 0.0; });
    if (!(count > few * world.fluid.size())) return "";
    const double more = parallel_sum(world.fluid.size(), [&](Index i) { return dense(i) ? excess(i) : 0.0; });
    ClosedRoom room;
    const Vec3d half = Vec3d(1, 1, plan.dimensions() - 2) * plan.spacing / 2;
    for (Index i = 0; i < world.fluid.size(); ++i)
        if (dense(i)) room.box.extend(x[i].cast<double>() - half), room.box.extend(x[i].cast<double>() + half);
    return fmt::format("more fluid than fits at {:.4g} s {}: it is {:.2g} % too dense there, {:.3g} m^{} ({:.0f} particles) too much", time,
                       room.place(), 100 * more / count, more * plan.particle_volume(), plan.dimensions(), more);
}

}  // namespace whorl
