#pragma once
/// Friction in the coupled solve for fluid that slides along solids with a slip length b (Navier's condition,
/// models/boundary/friction.h).
#include "engine/models/viscosity/coupled/coupled_rows.h"
#include "engine/particles/step_context.h"

namespace whorl {

/// Energy of the slip on the surface, dt mu/b |(u_s - u_wall)_t|^2/2 per area, with u_s - u_wall = b/(h + b) (u_i - u_wall) for the
/// particle next to the wall. The shear between the particle and the wall is that of the particle's row (WallPoint::stick).
struct ContactFriction {
    Column<Mat3> coefficient;  ///< dt mu/rho WallPoint::friction/d (1 - n n^T); empty: no such walls
    Column<Vec3> load;         ///< coefficient times the wall's velocity [m/s]

    void set(const CoupledRows& rows, Span<const Real> mu, const StepContext& step);
    bool acts() const { return !coefficient.empty(); }
    /// Contribution of one wall to the coefficient of its particle. @param mu viscosity of the particle
    static Mat3 of(const WallPoint& wall, Real mu, const StepContext& step) {
        return step.dt * mu / step.rest_density * wall.friction / step.spacing * (Mat3::Identity() - wall.normal * wall.normal.transpose());
    }
};

}  // namespace whorl
