#include <fmt/format.h>

#include <limits>

#include "engine/core/binary_io.h"
#include "engine/math/kernel.h"
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
        Index particle = 0;  ///< of the boundary
        double share = 0;    ///< of it that lies below the disc
    };
    struct Memory {
        double impulse = 0, time = 0, peak = 0;  ///< since the row before: N s, s, Pa
    };
    Index boundary_particles_;
    std::vector<Part> parts_;
    double area_ = 0;  ///< m^2; in two dimensions m
    std::string fault_;
    Memory memory_;
};

/// Wendland C2 function over its value at 0, 1.5 spacings wide: particles at edges of a surface hardly miss their neighbours.
double bump(double spacings) {
    const double q = spacings / 1.5;
    return q < 1 ? std::pow(1 - q, 4) * (1 + 4 * q) : 0;
}

// A boundary particle stands for the area S_0/S d^(D-1), S the sum of bumps over the particles on the same side, S_0 that of a lattice.
GaugeProbe::GaugeProbe(const ProbeKeys& keys, const World& world) : boundary_particles_(world.solid_particles.size()) {
    const SolidParticles& layer = world.solid_particles;
    const Solid& solid = world.solids.all[static_cast<std::size_t>(keys.solid)];
    const double d = static_cast<double>(world.step.spacing);
    const int dimensions = world.step.dimensions() - 1;
    const Vec3d normal = solid.normal(keys.at.cast<Real>()).cast<double>();
    double lattice = 0;
    each_lattice_point(dimensions, 2, [&](int a, int b, int) { lattice += bump(std::hypot(a, b)); });
    std::vector<Part> near;
    std::vector<Vec3d> place;
    for (Index s = 0; s < layer.size(); ++s) {
        const Vec3d n = layer.normal[s].cast<double>();
        if (layer.solid[static_cast<std::size_t>(s)] != keys.solid || n.dot(normal) < 0.5) continue;
        const Vec3 r = world.step.domain.minimum_image(layer.position[s] - keys.at.cast<Real>());
        const Vec3d at = r.cast<double>() + d / 2 * n;  // on the surface
        const double height = at.dot(normal), aside = (at - height * normal).norm();
        if (aside > keys.radius + 3 * d || std::abs(height) > keys.radius + d) continue;
        near.push_back({s, std::clamp((keys.radius - aside) / d + 0.5, 0.0, 1.0)});
        place.push_back(at);
    }
    for (std::size_t a = 0; a < near.size(); ++a) {
        if (near[a].share == 0) continue;
        double sum = 0;
        for (const Vec3d& b : place) sum += bump((b - place[a]).norm() / d);
        area_ += near[a].share * lattice / sum * std::pow(d, dimensions);
        parts_.push_back(near[a]);
    }
    if (parts_.empty())
        fault_ = fmt::format("the disc meets no surface of its solid, which is {:.4g} m away", std::abs(solid.distance(keys.at.cast<Real>())));
}

void GaugeProbe::after_step(const World& world, double) {
    const SolidParticles& layer = world.solid_particles;
    const double dt = static_cast<double>(world.step.dt);
    double impulse = 0;
    for (const Part& part : parts_) impulse -= part.share * layer.pressed[part.particle].dot(layer.normal[part.particle].cast<double>());
    const double pressure = impulse / (dt * area_);
    memory_.peak = memory_.time > 0 ? std::max(memory_.peak, pressure) : pressure;
    memory_.impulse += impulse, memory_.time += dt;
}

ProbeRows GaugeProbe::rows(const World&, double time) {
    const Memory m = std::exchange(memory_, {});
    const double none = std::numeric_limits<double>::quiet_NaN();
    return {{time, m.time > 0 ? m.impulse / (m.time * area_) : none, m.time > 0 ? m.peak : none}};
}

void GaugeProbe::save(std::ostream& out) const {
    put(out, memory_), put(out, area_), put(out, parts_.size());
    for (const Part& part : parts_) put(out, part);
}

void GaugeProbe::load(std::istream& in) {
    std::size_t count = 0;
    bool sound = take(in, memory_) && take(in, area_) && take(in, count) && area_ >= 0;
    parts_.clear();
    for (Part part; sound && parts_.size() < count; parts_.push_back(part))
        sound = take(in, part) && part.particle >= 0 && part.particle < boundary_particles_;
    if (!sound) throw EnvironmentError("the saved state is none of a gauge probe", "", "resume from an older checkpoint");
}

}  // namespace

std::unique_ptr<Probe> make_gauge_probe(const ProbeKeys& keys, const World& world) { return std::make_unique<GaugeProbe>(keys, world); }

}  // namespace whorl
