#pragma once
/// Options of the pressure models: the keys of [pressure], and what a plan adds to them.
#include <optional>

#include "engine/math/solve.h"
#include "engine/sph/gate.h"

namespace whorl {

enum class Preconditioner { automatic, none, jacobi, multigrid };
enum class PressureForm { constraint, projection };
/// Error that the equation of the projection removes: the divergence of the velocity or the error of the density.
enum class PressureSource { velocity, density };
/// How the particles and the coarse levels of a multigrid join: both corrections in sum, or one after the other as printed.
enum class MultigridCycle { additive, v_cycle };
/// symmetric: rho_i m_j (p_i/rho_i^2 + p_j/rho_j^2); difference: (m_j/rho_j)(p_j - p_i).
enum class GradientForm { symmetric, difference };

struct PressureOptions {
    /// constraint: relative density error (root mean square), of which a step may add half, if that is at most 5 % of the error that it is
    /// to correct. Source density: root mean square over the unknown particles of |r_i| dt^2/rho_0, the relative density error that the
    /// linear solve leaves; at most ten times that share of the right-hand side. coupled: preconditioned residual.
    SolveLimits limits{1e-3, 200};
    Preconditioner preconditioner = Preconditioner::automatic;  ///< ppe; coupled brings its own
    std::optional<PressureForm> form = {};                      ///< ppe; none: "auto"
    PressureSource source = PressureSource::velocity;           ///< projection
    bool clamp = true;                                          ///< source density: p = max(0, p) after the solve, as printed
    MultigridCycle cycle = MultigridCycle::additive;            ///< source density
    int sweeps = 1;                                             ///< source density: of a multigrid cycle, before and after each correction
    bool asks_for_multigrid() const { return cycle != MultigridCycle::additive || sweeps != 1; }
    /// Share of the density error that a step corrects; none: "auto", 0.5 of the constraint, 0.1 of source density. 1 is as printed; then
    /// an error e throws the fluid about with e d/dt and the pressure with rho_0 e H^2/dt^2, many times its weight.
    std::optional<double> correction = {};
    double damping = 2;              ///< constraint and source density: of motion between neighbours that is not resolved, times sqrt(g/d)
    double sound_speed = 0;          ///< wcsph: c0 [m/s]; ten times the largest speed keeps the density within 1 %
    double gamma = 7;                ///< wcsph: exponent of Tait's equation
    double background_pressure = 0;  ///< wcsph: p0 [Pa]; must be 0 where there is a free surface
    GradientForm gradient = GradientForm::symmetric;  ///< wcsph
    double sound_damping = 1;                         ///< wcsph: bulk viscosity over rho c0 R/2
    std::optional<double> artificial_viscosity = {};  ///< wcsph: alpha, shear viscosity over rho c0 R/(4 (D + 2)), R/20 in 3D

    // The rest has no keys.
    bool printed = false;  ///< source density: the printed rows (docs/physics.md 3)
    /// constraint: corrects 0.4 of that share, as near free bodies and in full periodic domains: a drop that surface tension holds together
    /// loses some of its pressure to a faster correction (a twentieth, with a radius of 11 spacings).
    bool slow_correction = false;
    Real solid_factor = 1;  ///< on the solids' volumes, see models/boundary/wall.h
    SolidGate gate = {};    ///< before solids
};

}  // namespace whorl
