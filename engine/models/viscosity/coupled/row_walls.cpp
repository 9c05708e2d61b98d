// Solids as neighbours: which particles they hold, and their part of a particle's density and moments (docs/physics.md 5).
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "engine/core/parallel.h"
#include "engine/models/viscosity/coupled/row_builder.h"

namespace whorl {

void CoupledRows::Walls::find(Span<const Vec3> x, Span<const std::int16_t> role, Real d, const CoupledOptions& o) {
    nearest.resize(solids.all.empty() ? 0 : x.size());
    if (nearest.empty()) return;
    height.resize(x.size()), touching.resize(x.size());
    parallel_for(static_cast<Index>(x.size()), [&](Index i) {
        nearest[i] = height[i] = std::numeric_limits<Real>::infinity();
        if (role[i] != 0) return;
        for (const Solid& solid : solids.all) {
            const Real distance = solid.distance(x[i]);
            nearest[i] = std::min(nearest[i], distance);
            if (solid.sticks()) height[i] = std::min(height[i], distance);
            else if (held[i] == 0 && distance < static_cast<Real>(o.wall_reach) * d) slip[i] = solid.normal(x[i]);
        }
        const Real reach = static_cast<Real>(held[i] < 0 ? o.wall_touch : o.wall_reach) * d;
        touching[i] = height[i] < reach ? 1 : -1;
    });
}

void CoupledRows::Walls::hold(Index i, const Found& found, const CoupledOptions& o) const {
    held[i] = touching[i];
    const Real touch = static_cast<Real>(o.wall_touch) * found.spacing, spread = static_cast<Real>(o.wall_spread) * found.spacing;
    if (held[i] < 0 && height[i] < spread)
        for (const Index j : found.close(i))
            if (touching[j] > 0 && height[j] < touch) held[i] = 1;
}

namespace {

/// Fraction of the integral of the weight of radius 1 that lies beyond a plane at distance q.
Real beyond(int dimensions, Real q) {
    if (q >= 1) return 0;
    if (dimensions == 2) {  // 128/(35 pi) times the integral of (1 - t^2)^(7/2) = cos^8 a da, t = sin a
        const double a = std::asin(static_cast<double>(q));
        const double waves = 28 * std::sin(2 * a) + 7 * std::sin(4 * a) + 4 * std::sin(6 * a) / 3 + std::sin(8 * a) / 8;
        return static_cast<Real>(0.5 - (a + waves / 35) / std::numbers::pi);
    }
    const Real t = q * q;
    return Real(0.5) - Real(315.0 / 256) * q * (1 - t * (Real(4.0 / 3) - t * (Real(1.2) - t * (Real(4.0 / 7) - t / 9))));
}

/// Fraction of the integral of the weight that lies in a solid, which may be thin. @param h distance of the solid's surface from x [m]
/// @param R radius of the weight [m]
Real filled(int dimensions, const Solid& solid, const Vec3& x, const Vec3& normal, Real h, Real R) {
    h = std::max(h, Real(0));
    if (!(h < R)) return 0;
    if (solid.distance(x - R * normal) < 0) return beyond(dimensions, h / R);
    constexpr int slabs = 4;
    Real sum = 0;
    for (int k = 0; k < slabs; ++k) {
        const Real from = h + (R - h) * k / slabs, to = h + (R - h) * (k + 1) / slabs;
        if (solid.distance(x - (from + to) / 2 * normal) < 0) sum += beyond(dimensions, from / R) - beyond(dimensions, to / R);
    }
    return sum;
}

}  // namespace

/// Fraction of the wall next to the particle that no other particle covers: 1 - sum b K over the particles nearer to the wall. K = (1 -
/// l^2/R^2)^2 depends on the distance l along the wall; its sum over a layer with one particle per spacing is about 1. b depends on how
/// much nearer to the wall the particle is.
Real CoupledRows::Scratch::uncovered(const Vec3& normal, int dimensions) const {
    const Real of_radius2 = dimensions == 2 ? Real(1.138) : Real(std::numbers::pi / 3);
    Real open = 1;
    for (std::size_t k = 0; k < index.size(); ++k) {
        const Real below = -(x[k] * normal[0] + y[k] * normal[1] + z[k] * normal[2]);
        if (!(below > Real(0.25))) continue;
        const Real bump = std::max(Real(0), 1 - (r2[k] - below * below) * of_radius2);
        open -= std::min(Real(1), 2 * below - Real(0.5)) * bump * bump;
    }
    return std::max(Real(0), open);
}

/// Finds the solids near the particle: their part of its density, and the wall points that hold it.
void CoupledRows::Scratch::find_walls(RowBlock& block, Index i, const Vec3& at, Real h, Real d, const Walls& walls, const CoupledOptions& o,
                                      Neighbourhood& n) const {
    const Solids& solids = walls.solids;
    const Real dt = walls.dt;
    const Real support = static_cast<Real>(o.support) * d, reach = static_cast<Real>(o.wall_reach) * d;
    // sum w z^2 over a half space full of particles, z: distance from its plane.
    const Real half_moment = walls.dimensions == 2 ? Real(std::numbers::pi / 80) * h * h * h * h
                                                   : Real(2 * std::numbers::pi / 3 * 16 / 1155) * h * h * h * h * h;
    const Real few = walls.dimensions == 2 ? 1 : 2;  // sum w is 1.2 for particles in a single file along the wall, 3.5 in a layer
    const std::size_t before = block.walls.size();
    constexpr Real no_lattice = Real(0.0119);  // deficit of each layer of a lattice that touches a flat wall
    Real open = 1;
    const auto count = [&](const Solid& solid, const Vec3& normal, Real height) {
        open *= 1 - std::max(Real(0), filled(walls.dimensions, solid, at, normal, height, support) - no_lattice);
    };
    const auto add = [&](const Solid& solid, Index k, const Vec3& normal, Real height) {
        const bool touches = solid.sticks() ? walls.held[i] > 0 : walls.slip[i] != Vec3::Zero();
        if (!touches || !(height < reach) || block.walls.size() - before == most_walls) return;
        WallPoint wall;
        wall.row = static_cast<Index>(row_first.size()) - 1;
        wall.solid = k;
        wall.normal = normal;
        const Real up = std::max(height / d, Real(0.2)),
                   hold = std::clamp((reach - height) / (Real(0.2) * d), Real(0), Real(1)) * uncovered(normal, walls.dimensions);
        if (!(hold > 0)) return;
        wall.position = at - up * d * normal;
        wall.velocity = velocity_over(solid, wall.position, dt);
        if (solid.body) {
            wall.body = static_cast<std::int32_t>(
                std::count_if(solids.all.begin(), solids.all.begin() + k, [](const Solid& other) { return other.body.has_value(); }));
            const Vec3 arm = solid.image(wall.position) - solid.body->centre.cast<Real>();
            wall.arm = arm + dt / 2 * solid.pose.angular_velocity.cross(arm);
        }
        wall.weight = hold * 2 * half_moment / up;
        const Real lone = std::max(Real(0), 1 - std::accumulate(w.begin(), w.end(), Real(0)) / few);
        if (!solid.sticks()) {
            const Real b = static_cast<Real>(solid.slip_length), whole = up * d + b;
            wall.stick = up * d / whole;
            wall.friction = solid.partial_slip() ? hold * b / (whole * whole) : 0;
        }
        wall.lateral = wall.stick * hold * lone * half_moment / 2 * (Mat3::Identity() - normal * normal.transpose());
        if (walls.dimensions == 2) wall.lateral(2, 2) = 0;
        n.volume *= 1 + hold * (up - Real(0.5));
        block.walls.push_back(wall);
    };
    for (std::size_t k = 0; k < solids.all.size(); ++k) {
        const Solid& solid = solids.all[k];
        const Real height = solid.distance(at);
        if (!(height < support)) continue;
        const Vec3 normal = solid.normal(at);
        if (!(height < reach)) {
            count(solid, normal, height);
            continue;
        }
        add(solid, static_cast<Index>(k), normal, height);
        Real bend = 0;  // sum of distance - height at four points beside the particle, at the distance `reach`; for curved surfaces
        // The four points also find other faces of the same solid that meet the nearest face in a concave edge.
        int along = 0;
        const Vec3 in_own_axes = solid.pose.rotation.transpose() * normal;
        in_own_axes.cwiseAbs().minCoeff(&along);
        const Vec3 axis = solid.pose.rotation.col(along), t = (axis - normal * normal.dot(axis)).normalized(), s = normal.cross(t);
        for (const Vec3& way : {t, Vec3(-t), s, Vec3(-s)}) {
            Vec3 there = at + reach * way;
            Real beyond_it = solid.distance(there);
            if (std::abs(beyond_it - height) > Real(1e-3) * d && (walls.dimensions == 3 || way.z() == 0) &&
                solid.normal(there).dot(normal) > Real(0.7))
                bend += beyond_it - height;
            if (!(beyond_it < 0)) beyond_it = solid.distance(there = at + reach / 2 * way);  // the solid may be thin
            if (!(beyond_it < 0)) continue;
            const Vec3 face = solid.normal(there);
            if (face.dot(normal) > Real(0.7)) continue;
            const Real face_height = beyond_it - (there - at).dot(face);
            add(solid, static_cast<Index>(k), face, face_height);
            count(solid, face, face_height);
        }
        // The mean square of a component along the wall, over the section of the kernel by the wall, is (R^2 - h^2)/10, in 2D (R^2 -
        // h^2)/9.
        const Real section = (support * support - height * height) / (reach * reach);
        count(solid, normal, height + bend * section / (walls.dimensions == 2 ? 18 : 20));
    }
    n.density += 1 - open;
    // In an edge or a corner the particle has fewer neighbours along each wall. With whole weights a uniform pressure would not balance
    // there.
    const auto first = block.walls.begin() + static_cast<std::ptrdiff_t>(before);
    for (auto wall = first; wall != block.walls.end(); ++wall)
        for (auto other = first; other != block.walls.end(); ++other) {
            const Real across = 1 - std::pow(wall->normal.dot(other->normal), 2), height = (at - other->position).norm();
            if (other != wall) wall->weight *= 1 - static_cast<Real>(o.edge_share) * across * beyond(walls.dimensions, height / (h * d));
        }
}

}  // namespace whorl
