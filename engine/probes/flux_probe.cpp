#include "engine/probes/flux_probe.h"

#include <limits>

#include "engine/core/binary_io.h"
#include "engine/particles/emitter.h"

namespace whorl {
namespace {

/// Spacings: no step moves a particle further than `step_reach`, so one that was nearer and is beyond `track_reach` was taken away.
constexpr double step_reach = 3, track_reach = 6;

}  // namespace

FluxProbe::FluxProbe(const ProbeKeys& keys, const World& world)
    : centre_(keys.at), radius_(keys.radius), half_width_(keys.width / 2), half_thickness_(keys.thickness / 2) {
    EmitterShape opening;
    opening.plane = world.step.dimensions() == 2;
    opening.direction = keys.direction.cast<Real>();
    Vec3 width, thickness;
    opening_axes(opening, width, thickness);
    axes_.row(0) = width.cast<double>(), axes_.row(1) = thickness.cast<double>(), axes_.row(2) = keys.direction;
    if (opening.plane) half_thickness_ = std::numeric_limits<double>::infinity();
    tracks_ = near_opening(world, track_reach);
}

/// From a place, in the opening's axes, to the opening [m].
double FluxProbe::distance(const Vec3d& place) const {
    if (radius_ > 0) return std::hypot(std::max(0.0, place.head<2>().norm() - radius_), place.z());
    return Vec3d(std::max(0.0, std::abs(place.x()) - half_width_), std::max(0.0, std::abs(place.y()) - half_thickness_), place.z()).norm();
}

FluxProbe::Tracks FluxProbe::near_opening(const World& world, double reach) const {
    const auto x = world.fluid.column<field::position>();
    const auto u = world.fluid.column<field::velocity>();
    const auto id = world.fluid.column<field::id>();
    const double most = reach * static_cast<double>(world.step.spacing);
    Tracks tracks;
    for (std::size_t k = 0; k < x.size(); ++k) {
        const Vec3d place = axes_ * world.step.domain.minimum_image(x[k] - centre_.cast<Real>()).cast<double>();
        if (distance(place) < most) tracks.emplace(id[k], Track{x[k].cast<double>(), place, axes_ * u[k].cast<double>()});
    }
    return tracks;
}

/// +1 or -1 if the path between two places, in the opening's axes, crosses the opening.
int FluxProbe::crossing(const Domain& domain, const Vec3d& from, const Vec3d& to) const {
    const bool was_beyond = from.z() >= 0, is_beyond = to.z() >= 0;
    if (was_beyond == is_beyond) return 0;
    const Vec3d at = from + from.z() / (from.z() - to.z()) * (to - from);
    const Vec3d place = axes_ * domain.minimum_image((axes_.transpose() * at).cast<Real>()).cast<double>();
    const bool through =
        radius_ > 0 ? place.head<2>().norm() <= radius_
                    : place.x() >= -half_width_ && place.x() < half_width_ && place.y() >= -half_thickness_ && place.y() < half_thickness_;
    return !through ? 0 : is_beyond ? 1 : -1;
}

void FluxProbe::after_step(const World& world, double) {
    const Domain& domain = world.step.domain;
    const double spacing = static_cast<double>(world.step.spacing), dt = static_cast<double>(world.step.dt);
    const auto role = roles(world);
    Tracks now = near_opening(world, track_reach);
    const auto id = world.fluid.column<field::id>();
    if (!role.empty())
        for (std::size_t k = 0; k < id.size(); ++k)
            if (in_nozzle(role, k)) tracks_.erase(id[k]);  // its path so far lies inside
    for (const auto& [number, before] : tracks_) {
        if (const auto found = now.find(number); found != now.end()) {
            const Vec3d moved = axes_ * domain.minimum_image((found->second.x - before.x).cast<Real>()).cast<double>();
            Vec3d to = before.place + moved;
            // The very number that the next path begins with, unless the particle went round a periodic domain.
            if (std::abs(to.z() - found->second.place.z()) < spacing / 100) to.z() = found->second.place.z();
            memory_.passed += crossing(domain, before.place, to);
        } else if (distance(before.place) < step_reach * spacing) {
            memory_.passed += crossing(domain, before.place, before.place + dt * before.velocity);
        }
    }
    tracks_ = std::move(now);
}

ProbeRows FluxProbe::rows(const World& world, double time) {
    const double mass = static_cast<double>(world.step.mass), volume = static_cast<double>(world.step.volume);
    const double rate = memory_.any_row && time > memory_.row_time ? (memory_.passed - memory_.passed_at_row) / (time - memory_.row_time)
                                                                   : std::numeric_limits<double>::quiet_NaN();
    memory_.passed_at_row = memory_.passed, memory_.row_time = time, memory_.any_row = true;
    return {{time, volume * rate, mass * rate, volume * memory_.passed, mass * memory_.passed}};
}

void FluxProbe::save(std::ostream& out) const { put(out, memory_); }

void FluxProbe::load(std::istream& in) {
    if (!take(in, memory_) || !is_truth(memory_.any_row))
        throw EnvironmentError("the saved state is none of a flux probe", "", "resume from an older checkpoint");
}

}  // namespace whorl
