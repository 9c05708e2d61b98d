#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "engine/core/binary_io.h"
#include "engine/probes/experiments.h"

namespace whorl {
namespace {

class GaugeProbe : public Probe {
public:
    GaugeProbe(const ProbeKeys& keys, const World& world);
    ProbeColumns columns() const override { return {{"time", "s", ""}, {"pressure", "Pa", "pressure"}, {"peak", "Pa", "pressure"}}; }
    std::string fault() const override { return fault_; }
    void after_step(const World& world, double time) override;
    ProbeRows rows(const World& world, double time) override;
    void save(std::ostream& out) const override;
    void load(std::istream& in) override;

private:
    struct Part {
        Index particle = 0;  ///< index of a boundary particle
        double share = 0;    ///< share of the particle that is below the disc
    };
    struct Memory {
        double impulse = 0, time = 0, peak = 0;  ///< since the previous row [N s, s, Pa]
    };
    Index boundary_particles_;
    std::vector<Part> parts_;
    double area_ = 0;  ///< m^2; in 2D m
    std::string fault_;
    Memory memory_;
};

// Every boundary particle below the disc represents the same area, the lower tercile of 1/sum W. The sums are over particles on the same
// side of the solid. W is the Wendland C2 kernel of the surface's dimension, with a support radius of three spacings. The tercile is low
// enough to exclude particles near edges, where missing neighbours enlarge 1/sum W.
GaugeProbe::GaugeProbe(const ProbeKeys& keys, const World& world) : boundary_particles_(world.boundary_particles.size()) {
    const BoundaryParticles& boundary = world.boundary_particles;
    const Solid& solid = world.solids.all[static_cast<std::size_t>(keys.solid)];
    const double d = static_cast<double>(world.step.spacing), R = 3 * d;
    const double norm = world.step.dimensions() == 2 ? 3 / (2 * R) : 7 / (std::numbers::pi * R * R);
    const Vec3d normal = solid.normal(keys.at.cast<Real>()).cast<double>();
    std::vector<Vec3d> place;
    // beyond: distance of each position in `place` from the rim of the disc [m], negative inside. areas: 1/sum W of the particles whose
    // neighbours are all in `place`.
    std::vector<double> beyond, areas;
    for (Index s = 0; s < boundary.size(); ++s) {
        const Vec3d n = boundary.normal[s].cast<double>();
        if (boundary.solid[static_cast<std::size_t>(s)] != keys.solid || n.dot(normal) < 0.5) continue;
        const Vec3 r = world.step.domain.minimum_image(boundary.position[s] - keys.at.cast<Real>());
        const Vec3d at = r.cast<double>() + d / 2 * n;  // on the surface
        const double height = at.dot(normal), past = (at - height * normal).norm() - keys.radius;
        if (past > 2 * R || std::abs(height) > keys.radius + d) continue;
        place.push_back(at), beyond.push_back(past);
        if (const double share = std::clamp(0.5 - past / d, 0.0, 1.0); share > 0) parts_.push_back({s, share});
    }
    if (parts_.empty()) {
        fault_ =
            fmt::format("the disc meets no surface of its solid, which is {:.4g} m away", std::abs(solid.distance(keys.at.cast<Real>())));
        return;
    }
    for (std::size_t a = 0; a < place.size(); ++a) {
        if (beyond[a] > R) continue;
        double sum = 0;
        for (const Vec3d& b : place)
            if (const double q = (b - place[a]).norm() / R; q < 1) sum += norm * std::pow(1 - q, 4) * (1 + 4 * q);
        areas.push_back(1 / sum);
    }
    const auto third = areas.begin() + static_cast<std::ptrdiff_t>(areas.size() / 3);
    std::nth_element(areas.begin(), third, areas.end());
    for (const Part& part : parts_) area_ += part.share * *third;
}

void GaugeProbe::after_step(const World& world, double) {
    const BoundaryParticles& boundary = world.boundary_particles;
    const double dt = static_cast<double>(world.step.dt);
    double impulse = 0;
    for (const Part& part : parts_)
        impulse -= part.share * boundary.pressed[part.particle].dot(boundary.normal[part.particle].cast<double>());
    const double pressure = impulse / (dt * area_);
    memory_.peak = memory_.time > 0 ? std::max(memory_.peak, pressure) : pressure;
    memory_.impulse += impulse, memory_.time += dt;
}

ProbeRows GaugeProbe::rows(const World&, double time) {
    const Memory m = std::exchange(memory_, {});
    return {{time, m.time > 0 ? m.impulse / (m.time * area_) : unknown, m.time > 0 ? m.peak : unknown}};
}

void GaugeProbe::save(std::ostream& out) const {
    put(out, memory_), put(out, area_), put(out, parts_.size());
    for (const Part& part : parts_) put(out, part.particle), put(out, part.share);
}

void GaugeProbe::load(std::istream& in) {
    std::size_t count = 0;
    bool sound = take(in, memory_) && take(in, area_) && take(in, count) && area_ >= 0;
    parts_.clear();
    for (Part part; sound && parts_.size() < count; parts_.push_back(part))
        sound = take(in, part.particle) && take(in, part.share) && part.particle >= 0 && part.particle < boundary_particles_;
    check_saved(sound, "gauge");
}

}  // namespace

std::unique_ptr<Probe> make_gauge_probe(const ProbeKeys& keys, const World& world) { return std::make_unique<GaugeProbe>(keys, world); }

}  // namespace whorl
