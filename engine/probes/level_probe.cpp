#include "engine/math/kernel.h"
#include "engine/probes/experiments.h"
#include "engine/probes/interpolation.h"

namespace whorl {
namespace {

constexpr double level_reach = 3, level_places = 4;  ///< support radius of the kernel [spacings]; number of sample points per spacing

class LevelProbe : public Probe {
public:
    explicit LevelProbe(const ProbeKeys& keys) : from_(keys.from), to_(keys.to) {}
    ProbeColumns columns() const override { return {{"time", "s", ""}, {"height", "m", "height of the surface"}}; }
    ProbeRows rows(const World& world, double time) override { return {{time, height(world)}}; }

private:
    double height(const World& world) const;
    Vec3d from_, to_;
};

double distance_to_solids(const Solids& solids, const Vec3& x) {
    Real distance = 0;
    solids.nearest(x, distance);
    return static_cast<double>(distance);
}

/// Fraction of the kernel that solids fill, by the midpoint rule over cubes of a spacing. A cube that a solid's surface cuts counts in
/// part.
double solid_share(const World& world, const Vec3& x, const WendlandC2Kernel& W) {
    const Real d = world.step.spacing;
    double all = 0, solid = 0;
    each_lattice_point(world.step.dimensions(), static_cast<int>(level_reach), [&](int a, int b, int c) {
        const Vec3 s = d * Vec3(static_cast<Real>(a), static_cast<Real>(b), static_cast<Real>(c));
        const auto weight = static_cast<double>(W.value(s.norm()));
        all += weight;
        if (weight > 0) solid += weight * std::clamp(0.5 - distance_to_solids(world.solids, x + s) / static_cast<double>(d), 0.0, 1.0);
    });
    return solid / all;
}

double LevelProbe::height(const World& world) const {
    const auto x = world.fluid.column<field::position>();
    const auto role = roles(world);
    const double d = static_cast<double>(world.step.spacing), length = (to_ - from_).norm();
    const WendlandC2Kernel W(static_cast<Real>(level_reach) * world.step.spacing, world.step.dimensions());
    const int last = std::max(1, static_cast<int>(std::ceil(level_places * length / d)));
    std::vector<Vec3d> places;
    for (int k = 0; k <= last; ++k) places.push_back(from_ + (to_ - from_) * k / last);
    const std::vector<std::vector<Index>> near = particles_near(world, places, level_reach * d);
    /// Fraction of the kernel that fluid fills, minus half of the fraction outside solids. It is 0 on the fluid's surface.
    const auto excess = [&](std::size_t k, double distance) {
        const auto place = places[k].cast<Real>();
        double share = 0;
        for (const Index j : near[k])
            if (!in_nozzle(role, static_cast<std::size_t>(j)))
                share += static_cast<double>(world.step.volume * W.value(world.step.domain.minimum_image(x[j] - place).norm()));
        return share - 0.5 * (1 - (distance < level_reach * d ? solid_share(world, place, W) : 0));
    };
    const double step = length / last;
    double height = 0, before = 0, gap = 0;  // gap: length without fluid or solid since the last point in either [m]
    bool was_in_fluid = false;
    for (std::size_t k = 0; k < places.size(); ++k) {
        const double distance = distance_to_solids(world.solids, places[k].cast<Real>());
        const double more = distance < -d / 2 ? -1 : excess(k, distance);
        const bool open = distance >= -d / 100;  // a line along a wall is not in the solid
        if (more >= 0) {
            if (open) height = static_cast<double>(k) * step;
            gap = 0;
        } else if (open) {
            if (was_in_fluid) return height + step * before / (before - more);
            gap += step;
            if (gap > d) return height;
        }
        was_in_fluid = more >= 0, before = more;
    }
    return height;
}

}  // namespace

std::unique_ptr<Probe> make_level_probe(const ProbeKeys& keys) { return std::make_unique<LevelProbe>(keys); }

}  // namespace whorl
