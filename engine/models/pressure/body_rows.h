#pragma once
/// The columns of D (density_rate.h) that belong to free bodies: their velocities are unknowns of the same solve.
#include "engine/geometry/body_contact.h"
#include "engine/models/pressure/density_rate.h"
#include "engine/particles/interaction_context.h"

namespace whorl {

/// Coupling of bodies and pressure:
///   (D u)_i also holds  -h_ib.(v_b + w_b x a_ib),   h_ib = f_i rho_i sum_{s of b} V_s grad W(|r'_is|),   a_ib = x_i - c_b.
/// A body that moves and turns with the fluid changes no density (w_i depends only on its position relative to i), hence its velocity
/// at x_i. The transpose pushes the body at x_i with the opposite of its push on i: momentum and angular momentum are conserved. In A = D
/// M^-1 D^T a body adds six directions, of the weight of a particle's mass over its own: however light it is, A stays symmetric and
/// positive semi-definite, and the step stable.
///
/// Contact is part of the solve: after a pressure q the bodies have the velocities v(q) = C(v - M_b^-1 m D_b^T q), C the law of
/// geometry/body_contact.h. C is linear as long as the same contacts press and stick, so an active set of contacts goes with that of
/// pressures: add_rates() applies C and notes which contacts hold, add_product() takes them as bound.
class BodyRows {
public:
    /// @param D built; its diagonal gets the bodies' share
    void build(const WallImage& wall, const InteractionContext& context, Span<const Real> rho, DensityRate& D);
    bool empty() const { return bodies_.empty(); }
    /// Whether fluid is in reach of a body.
    bool touched() const {
        return std::any_of(bodies_.begin(), bodies_.end(), [](const Body& body) { return !body.touches.empty(); });
    }
    /// Sets 1 for the particles that press on a body.
    void mark(std::vector<char>& particles) const {
        for (const Body& body : bodies_)
            for (const Touch& t : body.touches) particles[t.particle] = 1;
    }
    /// Adds D_b M_b^-1 m D_b^T q to `rate` where wanted, M_b^-1 with the contacts that held in the last add_rates().
    void add_product(Span<const Real> q, Span<const char> wanted, Span<Real> rate) const;
    /// Adds D_b (v - v(q)) to `rate` where wanted.
    void add_rates(Span<const Real> q, Span<const char> wanted, Span<Real> rate);
    /// Gives the bodies v(q).
    void push(Span<const Real> q, Solids& solids);
    /// The poses of all solids, the bodies' with the velocities v(q).
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
    /// Over the mass of a particle.
    Wrench transposed(const Body& body, Span<const Real> q) const;
    /// -m D_b^T q.
    BodyVector impulses(Span<const Real> q) const;
    /// Subtracts D_b v.
    void add_rates_of(const BodyVector& v, Span<const char> wanted, Span<Real> rate) const;
    /// v(q)
    BodyVector velocities_after(Span<const Real> q);

    std::vector<Body> bodies_;  ///< all free ones, in the solids' order
    BodyContacts contacts_;
    BodyVector start_;  ///< v
    double mass_ = 0;   ///< of a particle [kg]
};

}  // namespace whorl
