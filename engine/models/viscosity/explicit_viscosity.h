#pragma once
/// Viscosity without a solve: the XSPH smoothing and the explicit Laplacians.
///
/// Stages of a step: XsphViscosity after Kick; ExplicitViscosity between Gravity and Kick. Both need Density before them.
#include "engine/models/boundary/wall.h"
#include "engine/models/viscosity/viscosity_options.h"
#include "engine/particles/field.h"
#include "engine/particles/interaction_context.h"

namespace whorl {

namespace field {
struct smoothing {
    using type = Vec3;
    static constexpr std::string_view name = "smoothing", unit = "m/s", meaning = "change of velocity by the XSPH smoothing";
};
}  // namespace field

/// XSPH: u_i += alpha sum_j V_ij (u_j - u_i) W_ij over the fluid. V_ij = 2 m/(rho_i + rho_j) conserves momentum. The printed form has V_ij
/// = m/rho_j, which is the same if the density is uniform. Solids do not act. The smoothing acts as a viscosity that depends on the time
/// step (xsph_viscosity()).
struct XsphViscosity {
    Real alpha = Real(0.002);
    bool printed = false;
    void operator()(const InteractionContext& context, Read<field::role> role, Read<field::density> rho, Write<field::smoothing> change,
                    Update<field::velocity> u) const;
};

/// Approximate kinematic viscosity of XSPH [m^2/s]. @param dt time per smoothing by the fraction alpha [s]
inline double xsph_viscosity(double alpha, double support, double dt) { return alpha * 0.075 * support * support / (2 * dt); }

/// XSPH of the spin, as printed. Adds the work of the smoothing to the report. @param micro_inertia theta [m^2]
struct XsphSpin {
    Real beta = Real(0.125);
    double micro_inertia = 1;
    void operator()(const InteractionContext& context, StepReport& report, Read<field::role> role, Read<field::density> rho,
                    Write<field::smoothing> change, Update<field::spin> w) const;
};

/// a_i += mu/rho Lap u. A pair has mu_ij = 2 mu_i mu_j/(mu_i + mu_j), which conserves momentum and keeps the stress continuous at a jump of
/// mu.
///   brookshaw:  Lap u_i = f sum_j V_j (u_j - u_i) 2 |grad W_ij|/|r_ij|
///   monaghan:   Lap u_i = 2 (D + 2) f sum_j V_j (u_ij . r_ij)/(r_ij^2 + 0.01 h^2) grad W_ij       (Lap u + 2 grad(div u); no torque)
/// u_ij = u_i - u_j, h = R/2, D is the number of dimensions. The factor f, near 1, makes the sums over a lattice exact
/// (models/boundary/wall.h). No-slip solids act as neighbours, with the shear continued behind the surface (models/boundary/wall.h).
struct ExplicitViscosity {
    ViscosityOptions options;
    void operator()(const InteractionContext& context, Read<field::role> role, Read<field::density> rho, Read<field::viscosity> mu,
                    Read<field::velocity> u, Update<field::acceleration> a) const;
};

/// (Stiffness of `monaghan` on a cubic lattice)/(exact stiffness), for stretching along the axes and for shear between them. Both are 1 for
/// dense neighbours; with the cubic kernel and R = 2 d they are 1.45 and 0.70. Disordered particles have the mean over directions, which is
/// 1 within a few per cent.
struct LatticeStiffness {
    double stretching = 1, shear = 1;
};
/// @param support, spacing [m]
LatticeStiffness monaghan_lattice_stiffness(KernelForm kernel, double support, double spacing);

/// Limit of the time step of the explicit forms [s]: 0.125 R^2/(4 nu), for `monaghan` with nu times monaghan_stiffness(). With the cubic
/// kernel and R = 2 d, a lattice in 3D is stable up to 2.7 times this limit (`monaghan`: 1.9 times), and particles displaced from the
/// lattice by 0.25 d up to 2.2 times (1.3 times).
double viscous_step(double support, double kinematic_viscosity);
/// (Stiffness of a particle's diagonal block with `monaghan`)/(the same with `brookshaw`). They are 2 (D + 2)/D along each axis, and 2.
inline double monaghan_stiffness(int dimensions) { return (dimensions + 2.0) / dimensions; }

}  // namespace whorl
