// Positions of the particles of blocks, outside solids and in the pipes of emitters.
#include <cmath>
#include <limits>

#include "engine/core/random.h"
#include "engine/particles/boundary_sampling.h"
#include "engine/particles/sample.h"
#include "engine/simulation/initial_state.h"

namespace whorl {
namespace {

/// Moves each point at random by up to `most` along every axis [m], unless it would leave the shape or come too near to a solid.
void loosen(std::vector<Vec3>& points, double most, std::uint64_t seed, const Shape& shape, const World& world) {
    // The lattice points next to a wall are 0.5 spacings away from the wall.
    const auto nearest = static_cast<Real>(std::min(least_clearance, 0.5 - 1.25 * most / static_cast<double>(world.step.spacing)) *
                                           static_cast<double>(world.step.spacing));
    RandomNumbers random(seed);
    for (Vec3& x : points) {
        Vec3 moved = x;
        for (int a = 0; a < world.step.dimensions(); ++a) moved[a] += static_cast<Real>(most * (2 * random() - 1));
        Real distance = 0;
        if (shape.distance(moved) < 0 && (world.solids.nearest(moved, distance) < 0 || distance > nearest)) x = moved;
    }
}

/// Random displacement of a block's points [spacings]. A lattice at rest under gravity is an unstable equilibrium, and its symmetry
/// persists until rounding errors have grown enough. With weakly compressible pressure the lattice then collapses with a jolt of 3 % of
/// the free-fall speed, up to a second after the start (later in double precision). A lattice displaced by a hundredth of a spacing settles
/// gently from the start. With the projection, a lattice that the flow stretches keeps its rows until they buckle, with a jolt of up to
/// 5 % of the flow's velocity.
double looseness(const BlockKeys& keys, const PressureTraits& pressure) {
    if (keys.sampling == Sampling::jittered) return 0.2;
    return keys.sampling == Sampling::lattice ? pressure.loosens_lattice : 0;
}

/// Where a lattice lies in its shape.
struct Settling {
    Vec3 down = Vec3::Zero();  ///< unit vector along gravity; zero if gravity is not along an axis
    Real room = 0;  ///< from half a spacing above the lower end of the shape to the lowest layer [m]; negative: the layer is lower
};

Settling settling(const std::vector<Vec3>& points, const Shape& shape, const Vec3d& gravity, const StepContext& step) {
    Settling at;
    Vec3 low, high;
    shape.bounds(low, high);
    for (int a = 0; a < 3; ++a) {
        if (gravity[a] == 0 || step.domain.periodic[a] || std::abs(gravity[a]) < 0.99 * gravity.norm()) continue;
        const bool down = gravity[a] < 0;
        at = {(down ? -1 : 1) * Vec3::Unit(a), std::numeric_limits<Real>::max()};
        for (const Vec3& x : points)
            if (shape.distance(x) < 0) at.room = std::min(at.room, (down ? x[a] - low[a] : high[a] - x[a]) - step.spacing / 2);
    }
    return at;
}

void move(std::vector<Vec3>& points, const Vec3& by) {
    for (Vec3& x : points) x += by;
}

Real distance_from_solids(const World& world, const Vec3& x) {
    Real distance = 0;
    return world.solids.nearest(x, distance) >= 0 ? distance : std::numeric_limits<Real>::max();
}

/// Removes the points that are too near to solids. @return their number
std::size_t remove_in_solids(std::vector<Vec3>& points, const World& world) {
    return std::erase_if(
        points, [&](const Vec3& x) { return distance_from_solids(world, x) < static_cast<Real>(least_clearance) * world.step.spacing; });
}

/// Distance from the nearest solid [m] if the fluid sticks to that solid and the solid's surface is oblique to the layers of a lattice
/// (round or slanted); otherwise the largest Real.
Real distance_from_slanted(const World& world, const Vec3& x) {
    Real distance = std::numeric_limits<Real>::max();
    const int k = world.solids.nearest(x, distance);
    if (k < 0 || distance > 5 * world.step.spacing || distance < -world.step.spacing) return std::numeric_limits<Real>::max();
    const Solid& solid = world.solids.all[static_cast<std::size_t>(k)];
    if (!solid.sticks()) return std::numeric_limits<Real>::max();
    // The normal is evaluated behind the surface. Outside a box the normal varies near an edge; behind a face it is the normal of the face.
    const Vec3 behind = x - (distance + Real(0.1) * world.step.spacing) * solid.normal(x);
    return solid.normal(behind).cwiseAbs().maxCoeff() > Real(0.999) ? std::numeric_limits<Real>::max() : distance;
}

/// Gives the block as many particles near slanted and round solids as its volume requires. Without this, a lattice lacks least_clearance
/// spacings of fluid there, because points too near to the surface are removed. The required number is a sum over the points near the
/// surface. A lattice point counts as the fraction of its cell outside the solid, 0.5 + distance/spacing; a point of blue noise counts as 1
/// if it is outside. That number of points, those farthest from the solids, are kept, and relax() spreads them and the points nearby.
/// @param all points of the block, including those inside solids; for a lattice also the points up to half a spacing outside the block
void fill_beside_slanted(std::vector<Vec3>& points, const std::vector<Vec3>& all, bool on_lattice, const Shape& shape, const World& world) {
    const Real d = world.step.spacing;
    std::vector<std::pair<Real, Vec3>> near;
    double wanted = 0;
    for (const Vec3& x : all)
        if (const Real s = distance_from_slanted(world, x); std::abs(s) < d / 2 && (s < 0 || shape.distance(x) < 0))
            near.emplace_back(s, x), wanted += on_lattice ? 0.5 + static_cast<double>(s / d) : s > 0;
    if (near.empty()) return;
    // Distances are rounded, because round-off must not decide between points at equal distances.
    const auto far = [&](const auto& point) { return std::lround(1000 * point.first / d); };
    std::stable_sort(near.begin(), near.end(), [&](const auto& a, const auto& b) { return far(a) > far(b); });
    near.resize(static_cast<std::size_t>(std::lround(wanted)));
    std::vector<Vec3> rest, fixed, moved;
    for (const Vec3& x : points) {
        const Real s = distance_from_slanted(world, x);
        if (s >= d / 2) (s < Real(2.5) * d ? moved : distance_from_solids(world, x) < 5 * d ? fixed : rest).push_back(x);
    }
    for (const auto& [s, x] : near) moved.push_back(x);
    const auto from_solids = [&](const Vec3& x) { return distance_from_solids(world, x); };
    relax(
        moved, [&](const Vec3& x) { return std::max(shape.distance(x), -from_solids(x)); }, d, world.step.domain, 30, fixed, from_solids);
    points.swap(rest);
    points.insert(points.end(), fixed.begin(), fixed.end());
    points.insert(points.end(), moved.begin(), moved.end());
}

}  // namespace

std::vector<Vec3> points_of_block(const Scene& scene, const Plan& plan, const World& world, std::size_t b) {
    const BlockKeys& keys = scene.blocks[b];
    const auto shape = make_shape(keys.shape, world.step.domain);
    const std::uint64_t seed = scene.seed + 1000 * b;
    const auto sample = [&](Layers layers, Real beyond) {
        const Sampling even = keys.sampling == Sampling::jittered ? Sampling::lattice : keys.sampling;
        std::vector<Vec3> points = sample_shape(*shape, even, world.step.spacing, world.step.domain, seed, layers, beyond);
        if (layers == Layers::within) {
            // It would fall to the lower end of its shape. At most half a spacing is free at each end.
            const Settling at = settling(points, *shape, scene.domain.gravity(0), world.step);
            if (at.room > 0 && at.room <= world.step.spacing / 2) move(points, at.room * at.down);
            std::erase_if(points, [&](const Vec3& x) { return shape->distance(x) >= beyond; });
        }
        return points;
    };
    Layers layers = Layers::nearest;
    Vec3 lift = Vec3::Zero();
    const std::vector<Vec3> all = sample(layers, 0);
    std::vector<Vec3> points = all;
    if (remove_in_solids(points, world) > 0) {
        const bool on_lattice = keys.sampling != Sampling::blue_noise;
        if (on_lattice) {
            // Layers::nearest rounds the number of layers up if more than half of another layer fits. In a container, the layers at both
            // ends are then too near to the walls and are removed.
            std::vector<Vec3> within = sample(Layers::within, 0);
            remove_in_solids(within, world);
            if (within.size() >= points.size()) points.swap(within), layers = Layers::within;
            // On a floor only the lowest layer is removed, and the fluid would hover by a spacing. A lattice that is lifted instead is
            // outside the upper end of its shape by at most half a spacing.
            if (const Settling at = settling(all, *shape, scene.domain.gravity(0), world.step); at.room < 0) {
                std::vector<Vec3> lifted = all;
                move(lifted, at.room * at.down);
                remove_in_solids(lifted, world);
                if (lifted.size() > points.size()) points.swap(lifted), layers = Layers::nearest, lift = at.room * at.down;
            }
        }
        if (plan.traits.viscous()) {
            std::vector<Vec3> around = on_lattice ? sample(layers, world.step.spacing / 2) : all;
            move(around, lift);
            fill_beside_slanted(points, around, on_lattice, *shape, world);
        }
    }
    if (const double loose = looseness(keys, plan.traits.pressure); loose > 0)
        loosen(points, loose * static_cast<double>(world.step.spacing), seed, *shape, world);
    return points;
}

void fill_pipe(Emitter& emitter, const std::vector<std::shared_ptr<const Shape>>& shapes, const World& world,
               std::vector<std::vector<Vec3>>& points) {
    const Real d = world.step.spacing;
    std::vector<Vec3> taken;
    for (auto& of_block : points)
        std::erase_if(of_block, [&](const Vec3& x) {
            const bool inside = emitter.takes(x);
            if (inside) taken.push_back(x);
            return inside;
        });
    if (taken.empty()) return;
    const auto outside = [&](const Vec3& x) {
        Real least = std::numeric_limits<Real>::max();
        for (const auto& shape : shapes) least = std::min(least, shape->distance(x));
        return std::max(least, -distance_from_solids(world, x));
    };
    std::vector<Vec3> rest = emitter.filling();
    std::erase_if(rest, [&](const Vec3& x) { return !(outside(x) > 0); });
    relax(
        rest, [&](const Vec3& x) { return std::max(emitter.distance(x), -outside(x)); }, d, world.step.domain, 30, taken);
    taken.insert(taken.end(), rest.begin(), rest.end());
    emitter.be_full(std::move(taken));
}

}  // namespace whorl
