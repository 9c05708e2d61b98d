#pragma once
/// Friction in the coupled solve for fluid that slides along solids with a slip length b (Navier's condition,
/// models/boundary/friction.h).
#include "engine/geometry/solids.h"
#include "engine/models/viscosity/coupled/coupled_options.h"
#include "engine/particles/step_context.h"

namespace whorl {

/// Adds the energy V dt mu sum_i T(h_i)/(h_i + b) |(u_i - u_wall)_t|^2/2 over the particles near a wall. T distributes the wall's area over
/// the particles in front of it: 1/d up to a height of one spacing, decreasing to 0 at 1.1 d. For fluid at rest in layers a spacing apart,
/// sum_i V T(h_i) is the wall's area at any height of the first layer, so the fluid receives mu du_t/dn on that area.
struct ContactFriction {
    Column<Mat3> coefficient;  ///< dt mu/rho T/(h + b) (1 - n n^T); empty: no such walls
    Column<Vec3> load;         ///< coefficient times the wall's velocity [m/s]
    /// Fraction of a particle's volume that lies between the particle and the wall. The friction includes the shear there
    /// (WallFriction::counted).
    Column<Real> counted;

    void set(Span<const Vec3> x, Span<const std::int16_t> role, Span<const Real> mu, const Solids& solids, const StepContext& step);
    bool acts() const { return !coefficient.empty(); }
    /// Contribution of one solid: coefficient, counted volume of the particle, velocity of the wall.
    struct Share {
        Mat3 coefficient = Mat3::Zero();
        Real counted = 0;
        Vec3 wall = Vec3::Zero();
    };
    static Share share_of(const Solid& solid, const Vec3& x, Real mu, const StepContext& step);
};

}  // namespace whorl
