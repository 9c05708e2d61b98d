#pragma once
/// Friction of fluid that slides along solids with a slip length b (Navier's condition, models/boundary/friction.h), as the coupled solve
/// has it.
#include "engine/geometry/solids.h"
#include "engine/models/viscosity/coupled/coupled_options.h"
#include "engine/particles/step_context.h"

namespace whorl {

/// The energy V dt mu sum_i T(h_i)/(h_i + b) |(u_i - u_wall)_t|^2/2 over the particles near a wall. T spreads the wall's area over the
/// particles in front of it: 1/d up to the height of one spacing, less beyond, none from 1.1 d on. Fluid at rest in layers a spacing apart,
/// wherever the first of them lies, has sum_i V T(h_i) equal to the wall's area, so that it feels mu du_t/dn on it.
struct ContactFriction {
    Column<Mat3> coefficient;  ///< dt mu/rho T/(h + b) (1 - n n^T); empty: there are no such walls
    Column<Vec3> load;         ///< coefficient times the wall's velocity [m/s]
    Column<Real> counted;  ///< part of the particle's volume between it and the wall, whose shear is the friction's and not the strain's
                           ///< (WallFriction::counted)

    void set(Span<const Vec3> x, Span<const std::int16_t> role, Span<const Real> mu, const Solids& solids, const StepContext& step);
    bool acts() const { return !coefficient.empty(); }
    /// Contribution of one solid: its part of the coefficient and of the particle's counted volume, and its velocity.
    struct Share {
        Mat3 coefficient = Mat3::Zero();
        Real counted = 0;
        Vec3 wall = Vec3::Zero();
    };
    static Share share_of(const Solid& solid, const Vec3& x, Real mu, const StepContext& step);
};

}  // namespace whorl
