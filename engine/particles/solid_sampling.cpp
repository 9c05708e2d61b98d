#include "engine/particles/solid_sampling.h"

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

SolidParticles sample_solids(const Solids& solids, Real spacing, const Domain& domain, KernelForm kernel, Real support,
                             const std::function<Place(std::size_t)>& place_of) {
    SolidParticles particles;
    const LayerRegion world{spacing, domain, 3 * spacing, true};
    for (std::size_t k = 0; k < solids.all.size(); ++k) {
        const Solid& solid = solids.all[k];
        const bool turned = !solid.pose.rotation.isIdentity(0), bounded = solid.shape->bounded(), still = !solid.moves();
        // The box about a turned domain has an end along a periodic axis, where the solid goes on.
        LayerRegion region{spacing, in_own_axes(domain, solid.pose), world.margin, still && !(turned && bounded && domain.any_periodic())};
        if (!solid.spin.is_zero()) region.domain.periodic = {false, false, false};
        for (const LayerPoint& point : layer_of(solid, k, region, place_of)) {
            if (region.clipped && !region.contains(point.position)) continue;
            if (turned && (still || !bounded)) {
                const Vec3 x = solid.pose.rotation * point.position.cast<Real>() + solid.pose.translation;
                const Vec3d at = x.cast<double>();
                if (!(bounded ? world.contains(at) : contains_once(world, at))) continue;
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
