#pragma once
/// Options of the pressure models: the keys of [pressure], and values that a plan adds.
#include <optional>

#include "engine/math/solve.h"
#include "engine/sph/gate.h"

namespace whorl {

enum class Preconditioner { automatic, none, jacobi, multigrid };
enum class PressureForm { constraint, projection };
/// Error that the equation of the projection removes: the divergence of the velocity or the error of the density.
enum class PressureSource { velocity, density };
/// Combination of the particles and the coarse levels of a multigrid. additive: the corrections are added. v_cycle: they follow each other,
/// as printed.
enum class MultigridCycle { additive, v_cycle };
/// symmetric: rho_i m_j (p_i/rho_i^2 + p_j/rho_j^2); difference: (m_j/rho_j)(p_j - p_i).
enum class GradientForm { symmetric, difference };

struct PressureOptions {
    /// Tolerance, with a meaning for each model. constraint: root mean square of the relative density error. A step may add half of the
    /// tolerance, and at most 5 % of the error that the step has to correct. Source density: root mean square over the unknown particles of
    /// |r_i| dt^2/rho_0, the relative density error that the linear solve leaves; also, the residual is at most ten times the tolerance
    /// times the right-hand side. coupled: preconditioned residual.
    SolveLimits limits{1e-3, 200};
    Preconditioner preconditioner = Preconditioner::automatic;  ///< ppe; coupled has its own
    std::optional<PressureForm> form = {};                      ///< ppe; none: "auto"
    PressureSource source = PressureSource::velocity;           ///< projection
    bool clamp = true;                                          ///< source density: p = max(0, p) after the solve, as printed
    MultigridCycle cycle = MultigridCycle::additive;            ///< source density
    int sweeps = 1;                                             ///< source density: multigrid sweeps before and after each correction
    bool asks_for_multigrid() const { return cycle != MultigridCycle::additive || sweeps != 1; }
    /// Fraction of the density error that a step corrects; none: "auto", 0.5 for the constraint, 0.1 for source density. The printed form
    /// has 1. With 1, an error e in fluid of depth H gives velocities of e d/dt and pressures of rho_0 e H^2/dt^2, many times the weight.
    std::optional<double> correction = {};
    double damping = 2;              ///< constraint, source density: damping rate of unresolved motion in units of sqrt(g/d) (damping.h)
    double sound_speed = 0;          ///< wcsph: c0 [m/s]; with ten times the largest speed the density is within 1 %
    double gamma = 7;                ///< wcsph: exponent of Tait's equation
    double background_pressure = 0;  ///< wcsph: p0 [Pa]; must be 0 if there is a free surface
    GradientForm gradient = GradientForm::symmetric;  ///< wcsph
    double sound_damping = 1;                         ///< wcsph: (bulk viscosity)/(rho c0 R/2)
    std::optional<double> artificial_viscosity = {};  ///< wcsph: alpha, (shear viscosity)/(rho c0 R/(4 (D + 2))); R/20 in 3D

    // Members without a key.
    bool printed = false;  ///< source density: the printed rows (docs/physics.md 3)
    /// constraint; true: corrects 0.4 times `correction`, as near free bodies and in full periodic domains. With a faster correction a drop
    /// with surface tension loses some of its pressure (a twentieth, if the radius is 11 spacings).
    bool slow_correction = false;
    Real solid_factor = 1;  ///< factor on the volumes of boundary particles, see models/boundary/wall.h
    SolidGate gate = {};    ///< gate at solids
};

}  // namespace whorl
