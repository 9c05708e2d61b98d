#include "engine/core/binary_io.h"
#include "engine/particles/emitter.h"
#include "engine/probes/experiments.h"

namespace whorl {
namespace {

class FluxProbe : public Probe {
public:
    FluxProbe(const ProbeKeys& keys, const World& world);
    ProbeColumns columns() const override {
        return {{"time", "s", ""},
                {"volume_rate", "m^3/s", "volume a second"},
                {"mass_rate", "kg/s", "mass a second"},
                {"volume", "m^3", "volume that has passed"},
                {"mass", "kg", "mass that has passed"}};
    }
    void after_step(const World& world, double) override { follow(world); }
    ProbeRows rows(const World& world, double time) override;
    void save(std::ostream& out) const override { put(out, memory_); }
    void load(std::istream& in) override { check_saved(take(in, memory_), "flux"); }

private:
    struct Track {
        Vec3 x, velocity;  ///< position and velocity at the end of the previous step [m, m/s]
        long seen = 0;     ///< number of the last step with the particle; 0: none
    };
    struct Memory {
        double passed = 0, passed_at_row = 0, row_time = unknown;  ///< numbers of particles; time [s]
    };
    Vec3d place(const Domain& domain, const Vec3& x) const { return axes_ * domain.minimum_image(x - centre_).cast<double>(); }
    void follow(const World& world);
    int crossing(const StepContext& step, const Vec3& from, const Vec3& to) const;

    Vec3 centre_;
    Mat3d axes_;  ///< rows: along the width, along the thickness, normal to the opening
    double radius_, half_width_, half_thickness_;
    std::vector<Track> tracks_;  ///< by particle id
    long step_ = 0;
    Memory memory_;
};

FluxProbe::FluxProbe(const ProbeKeys& keys, const World& world)
    : centre_(keys.at.cast<Real>()), radius_(keys.radius), half_width_(keys.width / 2), half_thickness_(keys.thickness / 2) {
    EmitterShape opening;
    opening.plane = world.step.dimensions() == 2;
    opening.direction = keys.direction.cast<Real>();
    Vec3 width, thickness;
    opening_axes(opening, width, thickness);
    axes_.row(0) = width.cast<double>(), axes_.row(1) = thickness.cast<double>(), axes_.row(2) = keys.direction;
    if (opening.plane) half_thickness_ = std::numeric_limits<double>::infinity();
    follow(world);
}

/// +1 or -1 if the path between two positions crosses the opening, in or against its direction; otherwise 0.
int FluxProbe::crossing(const StepContext& step, const Vec3& from, const Vec3& to) const {
    const Vec3d a = place(step.domain, from), b = place(step.domain, to);
    Vec3d end = a + axes_ * step.domain.minimum_image(to - from).cast<double>();
    // The path must end at exactly the height at which the next path begins, so that every crossing counts once. The exception is a
    // particle that moved to another period.
    if (std::abs(end.z() - b.z()) < static_cast<double>(step.spacing) / 100) end.z() = b.z();
    if ((a.z() >= 0) == (end.z() >= 0)) return 0;
    const Vec3d met = a + a.z() / (a.z() - end.z()) * (end - a);
    const Vec3d at = place(step.domain, centre_ + (axes_.transpose() * met).cast<Real>());
    const bool through = radius_ > 0
                             ? at.head<2>().norm() <= radius_
                             : at.x() >= -half_width_ && at.x() < half_width_ && at.y() >= -half_thickness_ && at.y() < half_thickness_;
    return !through ? 0 : end.z() >= 0 ? 1 : -1;
}

void FluxProbe::follow(const World& world) {
    const auto x = world.fluid.column<field::position>();
    const auto u = world.fluid.column<field::velocity>();
    const auto id = world.fluid.column<field::id>();
    const auto role = roles(world);
    ++step_;
    for (std::size_t k = 0; k < x.size(); ++k) {
        const auto number = static_cast<std::size_t>(id[k]);
        if (number >= tracks_.size()) tracks_.resize(number + 1);
        Track& track = tracks_[number];
        if (track.seen > 0 && !in_nozzle(role, k)) memory_.passed += crossing(world.step, track.x, x[k]);
        track = {x[k], u[k], step_};
    }
    for (Track& track : tracks_) {
        if (track.seen == 0 || track.seen == step_) continue;
        memory_.passed += crossing(world.step, track.x, track.x + world.step.dt * track.velocity);
        track.seen = 0;  // removed
    }
}

ProbeRows FluxProbe::rows(const World& world, double time) {
    const double mass = static_cast<double>(world.step.mass), volume = static_cast<double>(world.step.volume);
    const double rate = time > memory_.row_time ? (memory_.passed - memory_.passed_at_row) / (time - memory_.row_time) : unknown;
    memory_.passed_at_row = memory_.passed, memory_.row_time = time;
    return {{time, volume * rate, mass * rate, volume * memory_.passed, mass * memory_.passed}};
}

}  // namespace

std::unique_ptr<Probe> make_flux_probe(const ProbeKeys& keys, const World& world) { return std::make_unique<FluxProbe>(keys, world); }

}  // namespace whorl
