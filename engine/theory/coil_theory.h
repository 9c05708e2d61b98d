#pragma once
/// Steady coiling of a slender viscous thread that falls on a plate: frequency and radius from theory, without a free parameter.
///
/// The theory is that of Ribe (2004), Proc. R. Soc. A 460, 3223: a thread that is stretched, bent and twisted against its viscosity by
/// gravity, inertia and (here) surface tension, steady in axes that turn with the coil. In these axes, with the arc length s from the
/// nozzle and ' = d/ds:
///
///     x axis of the thread, t its tangent, U speed along it, A = Q/U its cross-section, I = A^2/(4 pi), a its radius,
///     w angular velocity of a cross-section, N force and M moment in it, W = Omega e_z the coil's turning
///
///     x' = t                      t' = (w - W) x t / U
///     U' = (N.t - pi gamma a)/(3 eta A)                                       stretching, against surface tension
///     w' = (M - (M.t) t)/(3 eta I) + (M.t) t/(2 eta I)                        bending and twisting
///     N' = rho A (g e_z + U (U t)' + 2 U W x t + W x (W x x))                 weight and inertia
///     M' = -t x N                                                             (rotary inertia of sections is left out)
///
/// Nozzle, s = 0: x = 0, t = -e_z, U = U0, w = 0. Plate, s = L: the axis is one thread radius above it. Laid thread is at rest: U t + W x
/// x = 0 with horizontal t, and it neither rolls nor turns: w = 0. y = 0 fixes the phase. These are 18 conditions for 16 functions, Omega
/// and L.
#include <atomic>
#include <iosfwd>
#include <memory>
#include <optional>

namespace whorl {

struct CoilParameters {
    double nozzle_radius = 0;    ///< m
    double speed = 0;            ///< mean over the nozzle [m/s]
    double viscosity = 0;        ///< m^2/s, kinematic
    double gravity = 0;          ///< m/s^2, downwards
    double fall = 0;             ///< m, from the nozzle to the ground
    double surface_tension = 0;  ///< over the density [m^3/s^2]
};

/// Largest relative difference |p/q - 1| over the parameters, with the larger value as p; infinite if a parameter is zero on one side
/// only.
double relative_change(const CoilParameters& a, const CoilParameters& b);

struct CoilTheory {
    double frequency = 0;      ///< Hz
    double radius = 0;         ///< m, of the circle on which the thread's axis comes to rest
    double thread_radius = 0;  ///< there [m]
    double length = 0;         ///< of the falling thread [m]
};

/// Finds steady coils. It continues from the last one if the parameters have changed little.
class CoilSolver {
public:
    CoilSolver();
    ~CoilSolver();
    CoilSolver(CoilSolver&&) noexcept;
    CoilSolver& operator=(CoilSolver&&) noexcept;

    /// If all parameters are within a tenth of those of the last answer, the coil is continued from it. Otherwise (or if that fails) the
    /// solver follows the branch of coils from infinite viscosity, where there is exactly one coil, through its folds to the requested
    /// viscosity. If several coils are possible there (inertio-gravitational coiling: Ribe, Huppert, Hallworth, Habibi & Bonn 2006), the
    /// first that is met counts.
    /// @return empty if no coil was found within `most_effort` linear solves, if it would be no wider than its own thread (then it is not
    /// a coil), or if `give_up` became true
    std::optional<CoilTheory> at(const CoilParameters& parameters, const std::atomic<bool>* give_up = nullptr);
    /// Number of linear solves for the last answer.
    int effort() const;
    static constexpr int most_effort = 800;

    /// Saves the last coil, so that another solver continues from it bit-identically.
    void save(std::ostream& out) const;
    void load(std::istream& in);

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace whorl
