#include <algorithm>

#include "engine/particles/aggregates.h"
#include "engine/particles/search.h"
#include "engine/probes/experiments.h"

namespace whorl {
namespace {

constexpr double link = 1.5;  ///< largest distance between connected particles [spacings]

class ExtentProbe : public Probe {
public:
    explicit ExtentProbe(const ProbeKeys& keys) : origin_(keys.axis_point), ahead_(keys.direction), up_(keys.axis_direction) {}
    ProbeColumns columns() const override {
        return {{"time", "s", ""}, {"front", "m", "front"}, {"radius", "m", "radius"}, {"height", "m", "height"}};
    }
    ProbeRows rows(const World& world, double time) override;

private:
    Vec3d origin_, ahead_, up_;
};

/// Sets for each particle the number of its connected part; 0 for particles in nozzles. Parts are numbered from 1 in the order of their
/// first particles. @return number of parts
int find_parts(const World& world, Span<std::int32_t> part) {
    Pairs pairs;
    NeighbourSearch().find(world.fluid.column<field::position>(), static_cast<Real>(link) * world.step.spacing, world.step.domain, pairs);
    const auto role = roles(world);
    for (std::size_t k = 0; k < part.size(); ++k) part[k] = in_nozzle(role, k) ? 0 : 1;
    return split_unconnected([&](Index i, const auto& visit) { pairs.of(i, [&](Index j, const Vec3&, Real) { visit(j); }); }, part);
}

ProbeRows ExtentProbe::rows(const World& world, double time) {
    const auto x = world.fluid.column<field::position>();
    std::vector<std::int32_t> part(x.size());
    std::vector<Index> size(static_cast<std::size_t>(find_parts(world, part)), 0);
    for (const std::int32_t p : part)
        if (p > 0) ++size[p - 1];
    const auto largest = 1 + (std::max_element(size.begin(), size.end()) - size.begin());
    Vec3d most = Vec3d::Constant(size.empty() ? unknown : -std::numeric_limits<double>::infinity());
    for (std::size_t k = 0; k < x.size(); ++k) {
        if (part[k] != largest) continue;
        const Vec3d r = world.step.domain.minimum_image(x[k] - origin_.cast<Real>()).cast<double>();
        most = most.cwiseMax(Vec3d(r.dot(ahead_), (r - r.dot(up_) * up_).norm(), r.dot(up_)));
    }
    most.array() += static_cast<double>(world.step.spacing) / 2;
    return {{time, most.x(), most.y(), most.z()}};
}

}  // namespace

std::unique_ptr<Probe> make_extent_probe(const ProbeKeys& keys) { return std::make_unique<ExtentProbe>(keys); }

}  // namespace whorl
