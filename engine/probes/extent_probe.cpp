#include <numeric>

#include "engine/particles/search.h"
#include "engine/probes/experiments.h"

namespace whorl {
namespace {

constexpr double link = 1.5;  ///< spacings

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

/// Numbers of the particles in the largest connected part; of several, the one of the first particle.
std::vector<std::size_t> bulk(const World& world) {
    const auto x = world.fluid.column<field::position>();
    const auto role = roles(world);
    double reach_of_links = link * static_cast<double>(world.step.spacing);
    for (int a = 0; a < 3; ++a)
        if (world.step.domain.periodic[a]) reach_of_links = std::min(reach_of_links, static_cast<double>(world.step.domain.size()[a]) / 2);
    Pairs pairs;
    NeighbourSearch().find(x, static_cast<Real>(reach_of_links), world.step.domain, pairs);
    std::vector<std::size_t> parent(x.size()), count(x.size(), 0), found;
    std::iota(parent.begin(), parent.end(), 0);
    const auto root = [&](std::size_t k) {
        while (parent[k] != k) k = parent[k] = parent[parent[k]];
        return k;
    };
    for (std::size_t k = 0; k < x.size(); ++k)
        pairs.of(static_cast<Index>(k), [&](Index j, const Vec3&, Real) {
            if (in_nozzle(role, k) || in_nozzle(role, static_cast<std::size_t>(j))) return;
            const std::size_t a = root(k), b = root(static_cast<std::size_t>(j));
            parent[std::max(a, b)] = std::min(a, b);
        });
    for (std::size_t k = 0; k < x.size(); ++k)
        if (!in_nozzle(role, k)) ++count[root(k)];
    const auto largest = static_cast<std::size_t>(std::max_element(count.begin(), count.end()) - count.begin());
    for (std::size_t k = 0; k < x.size(); ++k)
        if (!in_nozzle(role, k) && root(k) == largest) found.push_back(k);
    return found;
}

ProbeRows ExtentProbe::rows(const World& world, double time) {
    const auto x = world.fluid.column<field::position>();
    Vec3d most = Vec3d::Constant(-std::numeric_limits<double>::infinity());
    const std::vector<std::size_t> fluid = bulk(world);
    for (const std::size_t k : fluid) {
        const Vec3d r = world.step.domain.minimum_image(x[k] - origin_.cast<Real>()).cast<double>();
        most = most.cwiseMax(Vec3d(r.dot(ahead_), (r - r.dot(up_) * up_).norm(), r.dot(up_)));
    }
    if (fluid.empty()) most.setConstant(std::numeric_limits<double>::quiet_NaN());
    most.array() += static_cast<double>(world.step.spacing) / 2;
    return {{time, most.x(), most.y(), most.z()}};
}

}  // namespace

std::unique_ptr<Probe> make_extent_probe(const ProbeKeys& keys) { return std::make_unique<ExtentProbe>(keys); }

}  // namespace whorl
