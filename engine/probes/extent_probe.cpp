#include "engine/probes/extent_probe.h"

#include <numeric>

#include "engine/particles/search.h"

namespace whorl {
namespace {

constexpr double link = 1.5;  ///< spacings

/// Numbers of the particles in the largest connected part; of several, the one of the first particle.
std::vector<std::size_t> bulk(const World& world) {
    const auto x = world.fluid.column<field::position>();
    const auto role = roles(world);
    double reach = link * static_cast<double>(world.step.spacing);
    for (int a = 0; a < 3; ++a)
        if (world.step.domain.periodic[a]) reach = std::min(reach, static_cast<double>(world.step.domain.size()[a]) / 2);
    Pairs pairs;
    NeighbourSearch().find(x, static_cast<Real>(reach), world.step.domain, pairs);
    std::vector<std::size_t> parent(x.size()), count(x.size(), 0);
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
    std::vector<std::size_t> found;
    if (count.empty()) return found;
    const auto largest = static_cast<std::size_t>(std::max_element(count.begin(), count.end()) - count.begin());
    for (std::size_t k = 0; k < x.size(); ++k)
        if (!in_nozzle(role, k) && root(k) == largest) found.push_back(k);
    return found;
}

}  // namespace

ProbeRows ExtentProbe::rows(const World& world, double time) {
    const auto x = world.fluid.column<field::position>();
    const double half = static_cast<double>(world.step.spacing) / 2;
    Vec3d most = Vec3d::Constant(-std::numeric_limits<double>::infinity());
    const std::vector<std::size_t> fluid = bulk(world);
    for (const std::size_t k : fluid) {
        const Vec3d r = world.step.domain.minimum_image(x[k] - origin_.cast<Real>()).cast<double>();
        most = most.cwiseMax(Vec3d(r.dot(ahead_), (r - r.dot(up_) * up_).norm(), r.dot(up_)));
    }
    if (fluid.empty()) most.setConstant(std::numeric_limits<double>::quiet_NaN());
    most.array() += half;
    return {{time, most.x(), most.y(), most.z()}};
}

}  // namespace whorl
