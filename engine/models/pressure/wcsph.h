#pragma once
/// Weakly compressible pressure: an equation of state, explicit in time.
///
/// Stages of a step, in order: Density (sph/density.h), TaitPressure, SoundDamping, Gravity, PressureAcceleration, ArtificialViscosity,
/// Kick, Move, PushOutOfSolids. Without the two dampers nothing is lost but by the time step: sound goes to and fro for ever, and a lattice
/// that melts stays warm.
#include "engine/models/pressure/pressure_options.h"
#include "engine/particles/field.h"
#include "engine/particles/interaction_context.h"

namespace whorl {

/// p = max(c0^2 rho_0/gamma ((rho/rho_0)^gamma - 1) + p0, 0)
struct TaitPressure {
    PressureOptions options;
    void operator()(const StepContext& step, Read<field::density> rho, Write<field::pressure> p) const;
};

/// A particle in a nozzle, whose velocity is prescribed, has the rest density and the pressure of the free fluid near it, like a solid
/// (Adami, Hu, Adams 2012): p_j = max(0, sum_i W_ji (p_i + rho_0 g . r_ji)/sum_i W_ji) over the free i. Its own density reflects the
/// packing within the nozzle, which must not push on the fluid in front.
struct NozzlePressure {
    void operator()(const InteractionContext& context, Read<field::role> role, Update<field::density> rho, Update<field::pressure> p) const;
};

/// p_i = max(0, p_i + b c0 R/2 (D rho/D t)_i),   (D rho/D t)_i = sum_j m u_ij . grad W_ij + rho_0 sum_s f V_s u_is . grad W_is
/// A bulk viscosity: its force is the transpose of the divergence that it is made of, so it only ever takes energy away; it conserves
/// momentum and angular momentum, and does nothing to a flow that keeps its density (free fall, rotation, shear).
struct SoundDamping {
    PressureOptions options;
    void operator()(const InteractionContext& context, Read<field::velocity> u, Update<field::pressure> p) const;
};

/// a_i += alpha c0 h sum_j m/rho_ij (u_ij . r_ij)/(r_ij^2 + 0.01 h^2) grad W_ij, h = R/2, rho_ij the mean     (Monaghan 1992, for receding
/// pairs too) A viscosity of nu = alpha c0 h/(2 (D + 2)). Conserves momentum and angular momentum. Solids that the fluid sticks to act with
/// their volumes.
struct ArtificialViscosity {
    PressureOptions options;
    void operator()(const InteractionContext& context, Read<field::role> role, Read<field::density> rho, Read<field::velocity> u,
                    Update<field::acceleration> a) const;
};

/// a_i -= grad p_i/rho_i, with
///   symmetric:   grad p_i = rho_i sum_j m (p_i/rho_i^2 + p_j/rho_j^2) grad W_ij     conserves momentum: use it where there is a free
///   surface difference:  grad p_i = sum_j m/rho_j (p_j - p_i) grad W_ij                     exact for constant p, does not conserve
///   momentum
/// A solid neighbour has the pressure of i and the weight of the fluid between them (as the solids of Adami, Hu, Adams 2012, a pair at a
/// time), and never pulls:
///   p_i + p_s = max(0, 2 p_i + rho_0 g . (x_s - x_i)).
/// Also along the wall: without that, fluid at a vertical wall feels half the gradient that carries it, sinks, and stirs the whole
/// basin. In the difference form it is p_s - p_i = max(-p_i, rho_0 g . (x_s - x_i)): only that weight pushes.
struct PressureAcceleration {
    PressureOptions options;
    void operator()(const InteractionContext& context, Read<field::role> role, Read<field::density> rho, Read<field::pressure> p,
                    Update<field::acceleration> a) const;
};

/// Limit of the time step from sound and flow: cfl h/(c0 + max|u|) with h = R/2 [s]. cfl 0.4 is usual.
double sound_step(double cfl, double support, double sound_speed, double max_speed);

/// Limit of the time step from SoundDamping, explicit in time: 0.6 h/(b c0) [s]. At cfl 0.4 it binds for b > 1.5.
double sound_damping_step(double support, double sound_speed, double sound_damping);

}  // namespace whorl
