#include "engine/probes/interpolation.h"

#include <numeric>

#include "engine/math/local_fit.h"

namespace whorl {
namespace {

constexpr double reach = 3, within = 1.2;  ///< spacings

}  // namespace

Interpolation interpolate(const World& world, const Vec3d& point, const std::vector<Index>& among) {
    const auto x = world.fluid.column<field::position>();
    const Span<const std::int16_t> role = world.fluid.has<field::role>() ? world.fluid.column<field::role>() : Span<const std::int16_t>();
    const double radius = reach * static_cast<double>(world.step.spacing);
    Interpolation found;
    std::vector<Vec3d> place;
    double nearest = 1;
    for (const Index k : among) {
        if (!role.empty() && role[k] < 0) continue;
        const Vec3d s = world.step.domain.minimum_image(x[k] - point.cast<Real>()).cast<double>() / radius;
        const double q = s.norm();
        if (!(q < 1)) continue;
        found.shares.push_back({k, 0});
        place.push_back(s);
        nearest = std::min(nearest, q);
    }
    if (place.empty()) return found;
    found.in_fluid = nearest < within / reach;
    const std::vector<double> weight = found.in_fluid ? fitted_at_origin(place) : mean_at_origin(place);
    for (std::size_t k = 0; k < weight.size(); ++k) found.shares[k].weight = weight[k];
    return found;
}

Interpolation interpolate(const World& world, const Vec3d& point) {
    std::vector<Index> all(static_cast<std::size_t>(world.fluid.size()));
    std::iota(all.begin(), all.end(), Index(0));
    return interpolate(world, point, all);
}

}  // namespace whorl
