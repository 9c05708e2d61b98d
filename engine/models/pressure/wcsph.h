#pragma once
/// Weakly compressible pressure: an equation of state, explicit in time.
///
/// Stages of a step, in order: Density (sph/density.h), TaitPressure, Gravity, PressureAcceleration, Kick, Move, KeepOutside.
#include "engine/geometry/solids.h"
#include "engine/particles/field.h"
#include "engine/particles/pairs.h"
#include "engine/particles/step.h"

namespace whorl {

struct WeaklyCompressible {
    double sound_speed = 0;          ///< c0 [m/s], ten times the largest speed keeps the density within 1 %
    double gamma = 7;
    double background_pressure = 0;  ///< p0 [Pa]; must be 0 where there is a free surface
    bool difference_gradient = false;  ///< (m_j/rho_j)(p_j - p_i) rather than rho_i m_j (p_i/rho_i^2 + p_j/rho_j^2)
    Real solid_factor = 1;           ///< on the solids' volumes, see models/boundary/wall.h
};

/// p = max(c0^2 rho_0/gamma ((rho/rho_0)^gamma - 1) + p0, 0)
struct TaitPressure {
    WeaklyCompressible options;
    void operator()(const StepContext& step, Read<field::density> rho, Write<field::pressure> p) const;
};

/// a_i -= grad p_i/rho_i, with
///   symmetric:   grad p_i = rho_i sum_j m (p_i/rho_i^2 + p_j/rho_j^2) grad W_ij     conserves momentum: use it where there is a free surface
///   difference:  grad p_i = sum_j m/rho_j (p_j - p_i) grad W_ij                     exact for constant p, does not conserve momentum
/// A solid neighbour mirrors the pressure of i and adds the weight of the fluid down to it; it acts in the symmetric form in either case
/// (in the difference form a wall with the pressure of i would not push).
struct PressureAcceleration {
    WeaklyCompressible options;
    void operator()(const FluidPairs& pairs, const SolidPairs& solid_pairs, const SolidParticles& solid, const StepContext& step,
                    Read<field::density> rho, Read<field::pressure> p, Update<field::acceleration> a) const;
};

/// Limit of the time step from sound and flow: cfl h/(c0 + max|u|) with h = R/2 [s]. cfl 0.4 is usual.
double sound_step(double cfl, double support, double sound_speed, double max_speed);

}  // namespace whorl
