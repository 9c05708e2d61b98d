#pragma once
/// The columns of D (density_rate.h) that belong to free bodies: their velocities are unknowns of the same solve.
#include "engine/models/pressure/density_rate.h"
#include "engine/particles/surroundings.h"

namespace whorl {

/// What bodies do to the densities, and pressures to the bodies:
///   (D u)_i also holds  -h_ib.(v_b + w_b x a_ib),   h_ib = f_i rho_i sum_{s of b} V_s grad W(|r'_is|),   a_ib = x_i - c_b.
/// A body that moves and turns with the fluid changes no density (w_i depends on where it stands relative to i alone), hence its velocity
/// at x_i. The transpose pushes the body at x_i with what it pushes i: momentum and angular momentum of both stay. In A = D M^-1 D^T a body
/// adds six directions, of the weight of a particle's mass over its own: however light it is, A stays symmetric and positive semi-definite,
/// and the step stable.
class BodyRows {
public:
    /// Velocity of the centre and angular velocity.
    struct Twist {
        Vec3 velocity, turning;
    };

    /// @param D built; its diagonal gets the bodies' share
    void build(const WallImage& wall, const Surroundings& around, Span<const Real> rho, DensityRate& D);
    bool empty() const { return bodies_.empty(); }
    /// Adds D_b M_b^-1 m D_b^T q to `rate` where wanted.
    void add_product(Span<const Real> q, Span<const char> wanted, Span<Real> rate) const;
    /// The bodies' part of u -= M^-1 D^T q.
    void push(Span<const Real> q, Solids& solids) const;
    /// The poses of all solids, the bodies' with the velocities after that part.
    std::vector<Pose> poses_after(Span<const Real> q, const Solids& solids) const;

private:
    struct Touch {
        Index particle;
        Vec3 h, arm;  ///< kg/m^4, m
    };
    struct Body {
        std::size_t solid;
        double mass_ratio;    ///< m over the body's
        Mat3d turning_ratio;  ///< m times the inverse of its inertia [1/m^2]
        std::vector<Touch> touches;
    };
    /// Over the mass of a particle.
    Wrench transposed(const Body& body, Span<const Real> q) const;

    std::vector<Body> bodies_;
    double mass_ = 0;  ///< of a particle [kg]
};

}  // namespace whorl
