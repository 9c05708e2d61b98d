#pragma once
/// Sums over the layers of solids to which the fluid sticks, and the viscous force on these solids.
#include "engine/models/bodies/reaction.h"
#include "engine/models/pressure/projection/projection_system.h"

namespace whorl {

/// Velocity of the wall's surface in front of boundary particle q.
inline Vec3 surface_velocity(const InteractionContext& context, Index q) {
    const BoundaryParticles& boundary = context.boundary;
    return boundary.velocity[q] +
           context.step.spacing / 2 * context.solids.all[boundary.solid[q]].pose.angular_velocity.cross(boundary.normal[q]);
}

/// Calls f(q, F, continued, to, distance) for each lattice layer behind boundary particle q near i. F = V W'/r [1/m^2]. `continued`, at
/// most 12, is the factor on u_i - u_wall that continues the shear into the layer. `to` points from the layer to i, `distance` is its
/// length. @param of_layer layer_factor() @param r from q to i
template <class Kernel, class Visit>
void each_layer_of(const Kernel& W, const ProjectionSystem& s, const InteractionContext& context, Index i, Real of_layer, Index q,
                   const Vec3& r, Visit&& f) {
    const Vec3& normal = context.boundary.normal[q];
    const Real d = context.step.spacing, above = r.dot(normal), volume = s.gate[i] * of_layer * context.boundary.volume[q],
               height = std::max(above - d / 2, d / 4);
    each_layer(r, normal, d, context.step.support, [&](const Vec3& to, Real distance, Real below) {
        f(q, volume * W.slope(distance), above > 0 ? std::min(Real(12), 1 + below / height) : Real(1), to, distance);
    });
}
/// Calls each_layer_of() for the boundary particles near i of solids to which the fluid sticks. @param slip slips() of the solids
template <class Kernel, class Visit>
void each_sticking_layer(const Kernel& W, const ProjectionSystem& s, const InteractionContext& context, Index i, Real of_layer,
                         const std::vector<char>& slip, Visit&& f) {
    if (!s.any_walls || context.solid_pairs.count(i) == 0) return;
    context.solid_pairs.of(i, [&](Index q, const Vec3& r, Real) {
        if (!slip[context.boundary.solid[q]]) each_layer_of(W, s, context, i, of_layer, q, r, f);
    });
}

/// Limit on the rate, times dt, at which layers pull a particle towards the velocity of a wall. The rate of a particle nearer to a wall
/// than d/3 would exceed it. Two explicit stages diverge above 2, of which the fluid needs up to 0.6 (viscous_step() allows for the fluid
/// alone).
inline Real sticking_share(Real rate) { return rate > 1 ? 1 / rate : Real(1); }

/// Sums for a Laplacian of f over a particle's neighbours, to which add_layers() adds the layers of the solids to which the fluid sticks.
struct StickingSums {
    Vec3 laplacian;  ///< sum m F (f_i - f_j), with the factor m of a pair
    Real trace;      ///< of -sum F r r^T
    Vec3 imbalance;  ///< sum F r

    /// @param own_factor m of the layers @param difference boundary particle -> f_i - f of the solid's surface
    /// @param rate (trace, sum |F| over the layers) -> rate for sticking_share(). A share leaves Laplacians of linear fields at 0.
    template <class Kernel, class Difference, class Rate>
    void add_layers(const Kernel& W, const ProjectionSystem& s, const InteractionContext& context, Index i, Real of_layer,
                    const std::vector<char>& slip, Real own_factor, const Difference& difference, const Rate& rate) {
        const Vec3 of_fluid = laplacian, imbalance_of_fluid = imbalance;
        Real stiffness = 0;
        each_sticking_layer(W, s, context, i, of_layer, slip, [&](Index q, Real F, Real continued, const Vec3& to, Real distance) {
            laplacian += own_factor * F * continued * difference(q);
            trace -= F * distance * distance;
            imbalance += F * to;
            stiffness -= F * continued;
        });
        if (const Real share = sticking_share(rate(trace, stiffness)); share < 1) {
            laplacian = of_fluid + share * (laplacian - of_fluid);
            imbalance = imbalance_of_fluid + share * (imbalance - imbalance_of_fluid);
        }
    }
};

/// Writes the viscous force on no-slip solids to the ledgers. On a rigid surface the stress is mu du/dn, with u the velocity relative to
/// the rigid motion of the solid continued into the fluid.
/// @param mu i -> viscosity [Pa s] @param over_lattice 1/lattice_gradient() of the kernel W
template <class Kernel, class Viscosity>
void write_sticking(const Kernel& W, const ProjectionSystem& s, const InteractionContext& context, Read<field::role> role,
                    Span<const Vec3> u, const Viscosity& mu, Real of_layer, Real over_lattice, const std::vector<char>& slip) {
    const StepContext& step = context.step;
    react(context, Push::viscous, role, step.volume * step.dt, [&](Index i) {
        Real trace = s.viscous.trace[i], stiffness = 0;
        each_sticking_layer(W, s, context, i, of_layer, slip, [&](Index, Real F, Real continued, const Vec3&, Real distance) {
            trace -= F * distance * distance, stiffness -= F * continued;
        });
        Real scale = mu(i) * s.laplacian_scale(step, i, trace, over_lattice);
        scale *= sticking_share(step.dt / step.rest_density * scale * stiffness);
        return [&, i, scale](Index q, const Vec3& r, Real) {
            const Solid& solid = context.solids.all[context.boundary.solid[q]];
            const Vec3 relative = u[i] - solid.pose.velocity_at(context.boundary.position[q] + r);
            Vec3 sum = Vec3::Zero();
            if (!slip[context.boundary.solid[q]])
                each_layer_of(W, s, context, i, of_layer, q, r,
                              [&](Index, Real F, Real continued, const Vec3&, Real) { sum += F * continued * relative; });
            return PushAt(scale * sum, r - step.spacing / 2 * context.boundary.normal[q]);
        };
    });
}

}  // namespace whorl
