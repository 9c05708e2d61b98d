#include "engine/particles/solid_sampling.h"

#include <cmath>
#include <limits>

#include "engine/core/parallel.h"
#include "engine/geometry/surface_layer.h"
#include "engine/particles/search.h"

namespace whorl {

namespace {

std::vector<LayerPoint> layer_of(const Solid& solid, std::size_t k, const LayerRegion& region,
                                 const std::function<Place(std::size_t)>& place_of) {
    try {
        return solid.shape->layer((solid.inside ? 1 : -1) * region.spacing / 2, region);
    } catch (const InputError& error) {
        Problem problem = error.problems().front();
        if (place_of) problem.place = place_of(k);
        problem.what = "solid[" + std::to_string(k) + "]: " + problem.what;
        throw InputError({std::move(problem)});
    }
}

}  // namespace

LayerRegion region_of_moving_plane(const Solid& plane, Real spacing, const Domain& domain, double end) {
    const Vec3d on_plane = turning_point(*plane.shape), n = plane.shape->normal(Vec3::Zero()).cast<double>();
    const Mat3d back = plane.pose.rotation.transpose().cast<double>();
    const Domain own = in_own_axes(domain, plane.pose);
    const Vec3d low = own.min.cast<double>(), high = own.max.cast<double>();
    Vec3d min = low, max = high;
    double reach = 0;
    constexpr int samples = 1024;
    for (int k = 0; k <= samples; ++k) {  // unevenly, so as not to fall in with an oscillation
        const double t = end * std::min(1.0, (k + std::fmod(0.618034 * k, 1.0)) / samples);
        const Vec3d moved = back * (plane.position(t) - plane.position(0));
        const Vec3d middle = (low + high) / 2 - moved, to_plane = n.dot(on_plane - middle) * n;
        min = min.cwiseMin(low - moved + to_plane), max = max.cwiseMax(high - moved + to_plane);
        reach = std::max(reach, (middle - on_plane).norm() + static_cast<double>(domain.size().norm()) / 2);
    }
    LayerRegion region{spacing, own, 3 * spacing, false};
    for (int a = 0; a < 3; ++a) {
        bool keeps_axis = std::abs(n[a]) < 1e-6;
        for (int b = 0; b < 3; ++b) {
            const Expression& spin = plane.spin.component[static_cast<std::size_t>(b)];
            keeps_axis = keeps_axis && (b == a || (spin.is_constant() && spin(0) == 0));
        }
        region.domain.periodic[a] = region.domain.periodic[a] && keeps_axis;
        if (region.domain.periodic[a] || (a == 2 && domain.dimensions() == 2)) continue;
        region.domain.min[a] = static_cast<Real>(plane.spin.is_zero() ? min[a] : on_plane[a] - reach);
        region.domain.max[a] = static_cast<Real>(plane.spin.is_zero() ? max[a] : on_plane[a] + reach);
    }
    return region;
}

SolidParticles sample_solids(const Solids& solids, Real spacing, const Domain& domain, KernelForm kernel, Real support,
                             const std::function<Place(std::size_t)>& place_of, double end) {
    SolidParticles particles;
    const LayerRegion world{spacing, domain, 3 * spacing, true}, slice{spacing, domain, std::numeric_limits<Real>::infinity(), true};
    for (std::size_t k = 0; k < solids.all.size(); ++k) {
        const Solid& solid = solids.all[k];
        const bool turned = !solid.pose.rotation.isIdentity(0), bounded = solid.shape->bounded(), still = !solid.moves();
        // The box about a turned domain has an end along a periodic axis, where the solid goes on.
        LayerRegion region{spacing, in_own_axes(domain, solid.pose), world.margin, still && !(turned && bounded && domain.any_periodic())};
        const bool moving_plane = !bounded && !still;
        if (moving_plane) region = region_of_moving_plane(solid, spacing, domain, end);
        else if (!solid.spin.is_zero()) region.domain.periodic = {false, false, false};
        for (const LayerPoint& point : layer_of(solid, k, region, place_of)) {
            if (region.clipped && !region.contains(point.position)) continue;
            if (moving_plane || (turned && still)) {
                const Vec3 x = solid.pose.rotation * point.position.cast<Real>() + solid.pose.translation;
                const Vec3d at = x.cast<double>();
                if (!(bounded ? world.contains(at) : contains_once(moving_plane ? slice : world, at))) continue;
            }
            particles.solid.push_back(static_cast<Index>(k));
            particles.own_position.push_back(point.position.cast<Real>());
            particles.own_normal.push_back((solid.inside ? -point.outward : point.outward).cast<Real>());
        }
    }
    const std::size_t n = particles.solid.size();
    particles.position.resize(n);
    particles.velocity.resize(n);
    particles.normal.resize(n);
    particles.volume.resize(n);
    particles.follow(solids);
    set_solid_volumes(particles, solids, domain, kernel, support > 0 ? support : 2 * spacing);
    return particles;
}

void set_solid_volumes(SolidParticles& particles, const Solids& solids, const Domain& domain, KernelForm kernel, Real support) {
    Pairs pairs;
    NeighbourSearch().find(particles.position, support, domain, pairs);
    std::vector<char> moves;
    for (const Solid& solid : solids.all) moves.push_back(solid.moves());
    with_kernel(kernel, support, [&](const auto& W) {
        parallel_for(particles.size(), [&](Index s) {
            Real sum = W.value(0);
            pairs.of(s, [&](Index other, const Vec3&, Real distance) {
                const Index a = particles.solid[s], b = particles.solid[other];
                if (a == b || (!moves[a] && !moves[b])) sum += W.value(distance);
            });
            particles.volume[s] = 1 / sum;
        });
    });
}

}  // namespace whorl
