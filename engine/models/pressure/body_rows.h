#pragma once
/// Columns of D (density_rate.h) for the free bodies, whose velocities are unknowns of the pressure's solve.
#include "engine/geometry/body_contact.h"
#include "engine/models/pressure/density_rate.h"
#include "engine/particles/interaction_context.h"

namespace whorl {

/// Coupling of bodies and pressure:
///   (D u)_i also contains  -h_ib.(v_b + w_b x a_ib),   h_ib = f_i rho_i sum_{s of b} V_s grad W(|r'_is|),   a_ib = x_i - c_b.
/// h_ib is the gradient of the density by the boundary particles s of body b, r'_is the vector to their image (WallImage), c_b the body's
/// centre. v_b and w_b are the body's velocity and angular velocity. The body's velocity at x_i is used, because w_i (density_rate.h)
/// depends only on the body's position relative to i: a body that moves and turns with the fluid changes no density. The transpose D^T
/// exerts on the body, at x_i, the opposite of the body's force on i, so momentum and angular momentum are conserved. In A = D M^-1 D^T a
/// body adds six columns to D, weighted with (mass of a particle)/(mass of the body). A stays symmetric and positive semi-definite for any
/// mass of the body, and the step is stable.
///
/// Contact is part of the solve. After a pressure q the bodies have the velocities v(q) = C(v - M_b^-1 m D_b^T q), with D_b the columns of
/// the bodies, M_b their inertia, m the mass of a particle and C the contact law of geometry/body_contact.h. C is linear while the same
/// contacts press and stick, so the contacts have an active set, like the pressures. add_rates() applies C and records the contacts that
/// hold; add_product() keeps this set of contacts.
class BodyRows {
public:
    /// @param D already built; the bodies' contribution is added to its diagonal
    void build(const WallImage& wall, const InteractionContext& context, Span<const Real> rho, DensityRate& D);
    bool empty() const { return bodies_.empty(); }
    /// Whether fluid is within the support of a body.
    bool touched() const {
        return std::any_of(bodies_.begin(), bodies_.end(), [](const Body& body) { return !body.touches.empty(); });
    }
    /// Sets 1 for the particles that are within the support of a body.
    void mark(std::vector<char>& particles) const {
        for (const Body& body : bodies_)
            for (const Touch& t : body.touches) particles[t.particle] = 1;
    }
    /// Adds D_b M_b^-1 m D_b^T q to `rate` where wanted. M_b^-1 includes the contacts that held in the last add_rates().
    void add_product(Span<const Real> q, Span<const char> wanted, Span<Real> rate) const;
    /// Adds D_b (v - v(q)) to `rate` where wanted.
    void add_rates(Span<const Real> q, Span<const char> wanted, Span<Real> rate);
    /// Sets the bodies' velocities to v(q).
    void push(Span<const Real> q, Solids& solids);
    /// Poses of all solids; those of the bodies have the velocities v(q).
    std::vector<Pose> poses_after(Span<const Real> q, const Solids& solids);

private:
    struct Touch {
        Index particle;
        Vec3 h, arm;  ///< kg/m^4, m
    };
    struct Body {
        std::size_t solid;
        std::vector<Touch> touches;
    };
    /// D_b^T q of one body.
    Wrench transposed(const Body& body, Span<const Real> q) const;
    /// -m D_b^T q.
    BodyVector impulses(Span<const Real> q) const;
    /// Subtracts D_b v from `rate` where wanted.
    void add_rates_of(const BodyVector& v, Span<const char> wanted, Span<Real> rate) const;
    /// v(q) = C(v - M_b^-1 m D_b^T q).
    BodyVector velocities_after(Span<const Real> q);

    std::vector<Body> bodies_;  ///< all free bodies, in the order of the solids
    BodyContacts contacts_;
    BodyVector start_;  ///< velocities v before the solve
    double mass_ = 0;   ///< of a particle [kg]
};

}  // namespace whorl
