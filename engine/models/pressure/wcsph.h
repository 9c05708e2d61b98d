#pragma once
/// Weakly compressible pressure: an equation of state, explicit in time.
///
/// Stages of a step, in order: Density (sph/density.h), TaitPressure, SoundDamping, Gravity, PressureAcceleration, ArtificialViscosity,
/// Kick, Move, PushOutOfSolids. Without SoundDamping and ArtificialViscosity only the time step dissipates energy. Sound then persists, and
/// particles that have left their lattice keep moving.
///
/// Symbols: c0 = options.sound_speed, gamma = options.gamma, p0 = options.background_pressure, b = options.sound_damping, f =
/// options.solid_factor, alpha = options.artificial_viscosity, R the support radius, u_ij = u_i - u_j, r_ij = x_i - x_j.
#include "engine/models/pressure/pressure_options.h"
#include "engine/particles/field.h"
#include "engine/particles/interaction_context.h"

namespace whorl {

/// p = max(c0^2 rho_0/gamma ((rho/rho_0)^gamma - 1) + p0, 0)
struct TaitPressure {
    PressureOptions options;
    void operator()(const StepContext& step, Read<field::density> rho, Write<field::pressure> p) const;
};

/// Gives prescribed particles (in a nozzle) the rest density and the pressure of the free fluid near them, as for a solid (Adami, Hu, Adams
/// 2012): p_j = max(0, sum_i W_ji (p_i + rho_0 g . r_ji)/sum_i W_ji) over the free particles i. The kernel sum of a prescribed particle j
/// depends on the packing within the nozzle, which must not push the fluid in front of the nozzle.
struct NozzlePressure {
    void operator()(const InteractionContext& context, Read<field::role> role, Update<field::density> rho, Update<field::pressure> p) const;
};

/// p_i = max(0, p_i + (b c0 R/2) (d rho/dt)_i),   (d rho/dt)_i = sum_j m u_ij . grad W_ij + rho_0 sum_s f V_s u_is . grad W_is
/// This is a bulk viscosity b rho c0 R/2. Its force is the transpose of the divergence, so it only removes energy. The force conserves
/// momentum and angular momentum, and does not act on flows of constant density (free fall, rotation, shear).
struct SoundDamping {
    PressureOptions options;
    void operator()(const InteractionContext& context, Read<field::velocity> u, Update<field::pressure> p) const;
};

/// a_i += alpha c0 h sum_j m/rho_ij (u_ij . r_ij)/(r_ij^2 + 0.01 h^2) grad W_ij,   h = R/2, rho_ij the mean of the two densities
/// (Monaghan 1992, for receding pairs too). In D dimensions this is a viscosity of nu = alpha c0 h/(2 (D + 2)). It conserves momentum and
/// angular momentum. No-slip solids act through the volumes of their boundary particles.
struct ArtificialViscosity {
    PressureOptions options;
    void operator()(const InteractionContext& context, Read<field::role> role, Read<field::density> rho, Read<field::velocity> u,
                    Update<field::acceleration> a) const;
};

/// a_i -= grad p_i/rho_i, with
///   symmetric:   grad p_i = rho_i sum_j m (p_i/rho_i^2 + p_j/rho_j^2) grad W_ij
///   difference:  grad p_i = sum_j m/rho_j (p_j - p_i) grad W_ij
/// The symmetric form conserves momentum; use it if there is a free surface. The difference form is exact for constant p and does not
/// conserve momentum. A solid neighbour s has the pressure of i plus the weight of the fluid between i and s, and never pulls (as the
/// solids of Adami, Hu, Adams 2012, but pair by pair):
///   p_i + p_s = max(0, 2 p_i + rho_0 g . (x_s - x_i)).
/// The weight also acts along the wall. Otherwise fluid at a vertical wall would have only half of the pressure gradient that supports it.
/// That fluid would sink and stir the whole basin. In the difference form p_s - p_i = max(-p_i, rho_0 g . (x_s - x_i)), so the solid
/// exerts only the weight.
struct PressureAcceleration {
    PressureOptions options;
    void operator()(const InteractionContext& context, Read<field::role> role, Read<field::density> rho, Read<field::pressure> p,
                    Update<field::acceleration> a) const;
};

/// Limit of the time step from sound and flow: cfl h/(c0 + max|u|) with h = R/2 [s]. cfl 0.4 is usual.
double sound_step(double cfl, double support, double sound_speed, double max_speed);

/// Limit of the time step from SoundDamping, which is explicit in time: 0.6 h/(b c0) [s]. At cfl 0.4 it is below sound_step() if b > 1.5.
double sound_damping_step(double support, double sound_speed, double sound_damping);

}  // namespace whorl
