#include "engine/particles/boundary_sampling.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "engine/core/parallel.h"
#include "engine/geometry/surface_samples.h"
#include "engine/particles/search.h"

namespace whorl {
namespace {

std::vector<SurfaceSample> layer_of(const Solid& solid, std::size_t k, const SamplingRegion& region, const std::optional<PlanePatch>& patch,
                                    const std::function<FileLocation(std::size_t)>& place_of) {
    const Real depth = (solid.inside ? 1 : -1) * region.spacing / 2;
    try {
        return patch ? patch->surface_samples(depth) : solid.shape->surface_samples(depth, region);
    } catch (const InputError& error) {
        Problem problem = error.problems().front();
        if (place_of) problem.place = place_of(k);
        problem.what = "solid[" + std::to_string(k) + "]: " + problem.what;
        throw InputError({std::move(problem)});
    }
}

/// Whether the solid does not rotate, or rotates only about the given one of its own axes.
bool keeps_axis(const Solid& solid, int axis) {
    for (int b = 0; b < 3; ++b) {
        const Expression& spin = solid.spin.component[static_cast<std::size_t>(b)];
        if (b != axis && !(spin.is_constant() && spin(0) == 0)) return false;
    }
    return true;
}

using Corners = std::array<Vec3d, 8>;

/// Corners of the domain, extended by `context` [m], in the own axes of the plane. Along periodic axes the domain moves with the plane,
/// because fluid that leaves on one side enters on the other.
Corners corners_in_own_axes(const Solid& plane, const Domain& domain, double context, double t) {
    Corners corners;
    const Vec3d moved = plane.position(t) - plane.position(0);
    for (unsigned i = 0; i < 8; ++i) {
        Vec3d x;
        for (int a = 0; a < 3; ++a) {
            const bool high = i >> a & 1, ends = !domain.periodic[a] && !(a == 2 && domain.dimensions() == 2);
            x[a] = (domain.periodic[a] ? moved[a] : 0.0) + (high ? domain.max : domain.min)[a] + (ends ? (high ? context : -context) : 0.0);
        }
        corners[i] = plane.pose.rotation.transpose().cast<double>() * (x - plane.pose.translation.cast<double>());
    }
    return corners;
}

/// BoundaryParticles::behind of a curved surface. A convex solid fills less of the kernels of nearby fluid than a flat wall does, and the
/// volumes of its boundary particles account for less than half of that effect. The rest is 0.26 to 0.32 times `curvature` on convex
/// surfaces and 0.3 to 0.37 times `curvature` on concave ones, by quadrature for spheres and circles of 3.5 to 12 spacings (cubic kernel,
/// R = 2 d). @param curvature sum of the principal curvatures, times the spacing
Real behind_surface(double curvature) {
    const double bent = 0.3 * curvature;
    return static_cast<Real>(bent > 0 ? 1 / (1 + bent) : 1 - bent);
}

/// Whether the point x of solid k [m, in its own axes] is on or in another fixed solid. An edge of solid k at such a point does not count
/// as an edge, because the other solid continues the surface.
bool covered(const Solids& solids, std::size_t k, const Vec3& x, Real spacing) {
    const Vec3 at = solids.all[k].pose.rotation * x + solids.all[k].pose.translation;
    for (std::size_t other = 0; other < solids.all.size(); ++other)
        if (other != k && !solids.all[other].moves() && solids.all[other].distance(at) < Real(0.75) * spacing) return true;
    return false;
}

/// The point a quarter of a spacing above the surface, at particle s.
Vec3 above(const BoundaryParticles& particles, Index s, Real spacing) {
    return particles.position[s] + Real(0.75) * spacing * particles.normal[s];
}

/// Whether the surface is flat around particle s. Tests points a quarter of a spacing above the surface, up to a spacing to each side. Each
/// point must be at that distance from the solids, or nearer to a solid whose surface is parallel or at right angles to that of s. A solid
/// that moves is tested without the others, because it may leave them.
bool flat_at(const BoundaryParticles& particles, Index s, const Solids& solids, Real spacing, int dimensions) {
    const Solid& own = solids.all[particles.solid[s]];
    const Real height = spacing / 4;
    const Vec3 n = particles.normal[s], foot = above(particles, s, spacing);
    const Vec3 along = dimensions == 2 ? Vec3(n.y(), -n.x(), 0) : n.unitOrthogonal(), across = n.cross(along);
    for (int k = 0; k < 4 * (dimensions - 1); ++k) {
        const Vec3 at = foot + (k % 2 ? 1 : -1) * (k / 2 % 2 ? spacing : spacing / 2) * (k < 4 ? along : across);
        Real distance = own.distance(at);
        const Solid* nearest = &own;
        for (const Solid& solid : solids.all)
            if (!own.moves() && !solid.moves())
                if (const Real one = solid.distance(at); one < distance) distance = one, nearest = &solid;
        if (distance > height + spacing / 200) return false;
        if (distance > height - spacing / 200) continue;
        const Real turn = std::abs(n.dot(nearest->normal(at)));
        if (turn > Real(0.01) && turn < Real(0.9999)) return false;
    }
    return true;
}

/// Whether x lies in the solid of particle s or in a solid at rest.
bool in_solid(const BoundaryParticles& particles, Index s, const Vec3& x, const Solids& solids, Real spacing) {
    for (std::size_t k = 0; k < solids.all.size(); ++k) {
        const Solid& solid = solids.all[k];
        if ((static_cast<Index>(k) == particles.solid[s] || !solid.moves()) && solid.distance(x) < -spacing / 8) return true;
    }
    return false;
}

}  // namespace

PlanePatch patch_of_moving_plane(const Solid& plane, Real spacing, const Domain& domain, Real support, double end) {
    constexpr int samples = 1024;
    constexpr double followed = 1000;  // s; later, a rotation that depends on time is assumed to reach any orientation
    const Vec3d on_plane = turning_point(*plane.shape), n = plane.shape->normal(Vec3::Zero()).cast<double>();
    SamplingRegion at_rest{spacing, in_own_axes(domain, plane.pose), 3 * spacing, false};
    for (int a = 0; a < 3; ++a) {
        at_rest.domain.periodic[a] = at_rest.domain.periodic[a] && std::abs(n[a]) < 1e-6 && keeps_axis(plane, a);
    }
    PlanePatch patch(on_plane, n, at_rest);
    Solids alone;
    alone.all = {plane};
    Corners corners, before;
    for (int k = 0; k <= samples; ++k) {  // uneven times, so that they do not coincide with an oscillation
        const double t = end * std::min(1.0, (k + std::fmod(0.618034 * k, 1.0)) / samples);
        const bool known = t <= followed || !plane.spin.depends_on_time();
        if (!known) alone.all[0].spin = {};
        alone.set_time(t, 0);
        corners = corners_in_own_axes(alone.all[0], domain, 2 * support, t);
        if (!known) {
            for (const Vec3d& x : corners)
                for (const Vec3d& along : patch.lattice().direction)
                    for (const double side : {-1.0, 1.0})
                        if (x.allFinite()) patch.add(on_plane + side * (x - on_plane).norm() * along);
            continue;
        }
        if (k == 0 && plane.spin.is_zero())
            for (const Vec3d& x : corners) patch.add(x);
        for (unsigned i = 0; i < 8; ++i) {
            for (unsigned axis = 1; axis < 8; axis *= 2)
                if (!(i & axis)) patch.add_crossing(corners[i], corners[i | axis]);
            if (k > 0) patch.add_crossing(before[i], corners[i]);
        }
        before = corners;
    }
    return patch;
}

BoundaryParticles sample_solids(const Solids& solids, Real spacing, const Domain& domain, KernelForm kernel, Real support,
                                const std::function<FileLocation(std::size_t)>& place_of, double end) {
    BoundaryParticles particles;
    const Real reach = support > 0 ? support : 2 * spacing;
    const SamplingRegion world{spacing, domain, 3 * spacing, true}, slice{spacing, domain, std::numeric_limits<Real>::infinity(), true};
    for (std::size_t k = 0; k < solids.all.size(); ++k) {
        const Solid& solid = solids.all[k];
        const bool turned = !solid.pose.rotation.isIdentity(0), bounded = solid.shape->bounded(), still = !solid.moves();
        // The box that contains a rotated domain ends along a periodic axis, although the solid continues there.
        SamplingRegion region{spacing, in_own_axes(domain, solid.pose), world.margin,
                              still && !(turned && bounded && domain.any_periodic())};
        std::optional<PlanePatch> patch;
        if (!bounded && !still) patch = patch_of_moving_plane(solid, spacing, domain, reach, end);
        for (int a = 0; a < 3; ++a) region.domain.periodic[a] = region.domain.periodic[a] && keeps_axis(solid, a);
        for (const SurfaceSample& point : layer_of(solid, k, region, patch, place_of)) {
            if (region.clipped && !region.contains(point.position)) continue;
            if (patch || (turned && still)) {
                const Vec3 x = solid.pose.rotation * point.position.cast<Real>() + solid.pose.translation;
                const Vec3d at = x.cast<double>();
                if (!(bounded ? world.contains(at) : contains_once(patch ? slice : world, at))) continue;
            }
            particles.solid.push_back(static_cast<Index>(k));
            particles.own_position.push_back(point.position.cast<Real>());
            particles.own_normal.push_back((solid.inside ? -point.outward : point.outward).cast<Real>());
            const bool edge = !solid.inside && !point.concave && !point.face.isZero() &&
                              !(still && covered(solids, k, particles.own_position.back(), spacing));
            particles.behind.push_back(edge ? 0 : behind_surface((solid.inside ? -1 : 1) * point.curvature * static_cast<double>(spacing)));
            particles.own_face.push_back(edge ? Vec3(point.face.cast<Real>()) : Vec3::Zero());
            particles.flat.push_back(edge ? 0 : point.face.isZero() ? 1 : -1);
        }
    }
    const std::size_t n = particles.solid.size();
    particles.position.resize(n);
    particles.velocity.resize(n);
    particles.normal.resize(n);
    particles.face.resize(n);
    particles.volume.resize(n);
    particles.follow(solids);
    set_solid_volumes(particles, solids, domain, kernel, reach);
    return particles;
}

void join_surfaces(BoundaryParticles& particles, const Solids& solids, const StepContext& step) {
    const Real d = step.spacing;
    std::vector<char> block;  // bounded, with the fluid outside
    for (const Solid& solid : solids.all) block.push_back(solid.shape->bounded() && !solid.inside);
    std::vector<char> hidden(static_cast<std::size_t>(particles.size()));
    parallel_for(particles.size(), [&](Index s) {
        const std::size_t own = static_cast<std::size_t>(particles.solid[s]);
        Vec3 n = particles.normal[s];
        const auto ahead = [&] { return Vec3(particles.position[s] + Real(0.75) * d * n); };
        const auto each_other = [&](auto&& f) {
            for (std::size_t k = 0; k < solids.all.size() && !hidden[s]; ++k)
                if (k != own && (block[k] || block[own]) && !solids.all[k].moves()) f(solids.all[k]);
        };
        if (solids.all[own].moves()) return;
        for (int face = 0; face < 2; ++face)
            each_other([&](const Solid& other) {
                if (!(other.distance(ahead()) < d / 10)) return;
                const Vec3 m = other.normal(ahead());
                n -= std::min(Real(0), n.dot(m)) * m;
                hidden[s] = n.norm() < Real(0.3);
                n.normalize();
            });
        each_other([&](const Solid& other) { hidden[s] |= other.distance(ahead()) < -d / 8; });
        if (hidden[s] || n == particles.normal[s]) return;
        particles.normal[s] = n, particles.own_normal[s] = solids.all[own].pose.rotation.transpose() * n;
        const bool face = std::abs(solids.all[own].distance(particles.position[s] + d / 2 * n)) < d / 20;
        particles.flat[s] = particles.behind[s] = face ? 1 : 0;
    });
    if (std::find(hidden.begin(), hidden.end(), 1) == hidden.end()) return;
    particles.remove(hidden);
    set_solid_volumes(particles, solids, step.domain, step.kernel, step.support);
}

void find_flat_walls(BoundaryParticles& particles, const Solids& solids, const StepContext& step) {
    // Whether solids cover particle s or the way from s along the vector `to`. For example, a wall on a floor covers the floor below the
    // wall and hides the end of the floor from particles on the other side.
    const auto hidden = [&](Index s, const Vec3& to) {
        const Vec3 from = above(particles, s, step.spacing);
        for (const Real part : {Real(0), Real(0.25), Real(0.5), Real(0.75)})
            if (in_solid(particles, s, from + part * to, solids, step.spacing)) return true;
        return false;
    };
    parallel_for(particles.size(), [&](Index s) {
        const Solid& own = solids.all[particles.solid[s]];
        if (!own.moves() && particles.flat[s] >= 0 && hidden(s, Vec3::Zero())) particles.flat[s] = -1;
        if (particles.flat[s] > 0 && (own.body || !flat_at(particles, s, solids, step.spacing, step.dimensions()))) particles.flat[s] = 0;
    });
    // The particles that are not flat, with explicit periodic images, because a periodic axis may be too short for a search over 2 R.
    Domain open = step.domain;
    open.periodic = {};
    const Vec3 period = step.domain.period();
    std::vector<Index> rough;
    Column<Vec3> at;
    for (Index s = 0; s < particles.size(); ++s)
        for (int image = 0; particles.flat[s] == 0 && image < 27; ++image) {
            const Vec3 shift = Vec3(Real(image % 3 - 1), Real(image / 3 % 3 - 1), Real(image / 9 - 1));
            if ((shift.array() != 0 && period.array() == 0).any()) continue;
            rough.push_back(s), at.push_back(particles.position[s] + shift.cwiseProduct(period));
        }
    Pairs pairs;
    NeighbourSearch().find(particles.position, at, 2 * step.support, open, pairs);
    parallel_for(particles.size(), [&](Index s) {
        pairs.of(s, [&](Index k, const Vec3& r, Real distance) {
            const Index own = particles.solid[s], its = particles.solid[rough[k]];
            const Real flat = flat_beside(distance, step.support);
            if (flat < particles.flat[s] && (own == its || (!solids.all[own].moves() && !solids.all[its].moves())) && !hidden(s, -r))
                particles.flat[s] = flat;
        });
    });
    if (std::none_of(particles.flat.begin(), particles.flat.end(), [](Real flat) { return flat > 0; })) particles.flat.clear();
}

void set_solid_volumes(BoundaryParticles& particles, const Solids& solids, const Domain& domain, KernelForm kernel, Real support) {
    Pairs pairs;
    NeighbourSearch().find(particles.position, support, domain, pairs);
    std::vector<char> moves, shells, edges(solids.all.size());
    for (const Solid& solid : solids.all) moves.push_back(solid.moves()), shells.push_back(solid.shape->shell());
    for (Index s = 0; s < particles.size(); ++s) edges[particles.solid[s]] |= particles.behind[s] == 0;
    // Whether `other` is on the same face as s, or on a face that continues it. Lattice points on an edge belong to both faces at the edge.
    // The other side of a vessel's wall acts on other fluid.
    const auto counts = [&](Index s, Index other) {
        const Index a = particles.solid[s], b = particles.solid[other];
        const bool edge = particles.behind[s] == 0 || particles.behind[other] == 0;
        const Real turn = particles.normal[s].dot(particles.normal[other]);
        if (a == b && shells[a] && turn < Real(-0.5)) return false;
        if (a == b) return edge || !edges[a] || std::abs(turn) > Real(0.5);
        return !moves[a] && !moves[b] && (!edge || turn > Real(-0.5));
    };
    with_kernel(kernel, support, [&](const auto& W) {
        parallel_for(particles.size(), [&](Index s) {
            Real sum = W.value(0);
            pairs.of(s, [&](Index other, const Vec3&, Real distance) {
                if (counts(s, other)) sum += W.value(distance);
            });
            particles.volume[s] = 1 / sum;
        });
    });
}

}  // namespace whorl
