#pragma once
/// Steady coiling of a slender viscous thread that falls on a plate: frequency and radius from theory, without a free parameter.
///
/// The theory is that of Ribe (2004), Proc. R. Soc. A 460, 3223: a thread that is stretched, bent and twisted against its viscosity by
/// gravity, inertia and (here) surface tension, steady in axes that turn with the coil. In these axes, with the arc length s from the
/// nozzle, ' = d/ds, and x between vectors for the cross product:
///
///     x axis of the thread, t tangent of the axis, U speed along the axis, Q volume flux, A = Q/U cross-section, I = A^2/(4 pi),
///     a radius of the thread, w angular velocity of a cross-section, N force and M moment in a cross-section,
///     W = Omega e_z angular velocity of the coil, rho density, eta viscosity, gamma surface tension, g gravity
///
///     x' = t                      t' = (w - W) x t / U
///     U' = (N.t - pi gamma a)/(3 eta A)                                       stretching, against surface tension
///     w' = (M - (M.t) t)/(3 eta I) + (M.t) t/(2 eta I)                        bending and twisting
///     N' = rho A (g e_z + U (U t)' + 2 U W x t + W x (W x x))                 weight and inertia
///     M' = -t x N                                                             (rotary inertia of sections is left out)
///
/// At the nozzle, s = 0: x = 0, t = -e_z, U = U0, w = 0. At the plate, s = L: the axis is one thread radius above the plate. The laid
/// thread is at rest, U t + W x x = 0 with horizontal t, and neither rolls nor turns, w = 0. The coordinate y of the axis is 0, which fixes
/// the phase of the coil. These are 18 conditions for 16 functions, Omega and L.
#include <atomic>
#include <iosfwd>
#include <memory>
#include <optional>

namespace whorl {

struct CoilParameters {
    double nozzle_radius = 0;    ///< m
    double speed = 0;            ///< mean speed of the fluid in the nozzle [m/s]
    double viscosity = 0;        ///< m^2/s, kinematic
    double gravity = 0;          ///< m/s^2, downwards
    double fall = 0;             ///< m, from the nozzle to the ground
    double surface_tension = 0;  ///< surface tension over density [m^3/s^2]
};

/// Largest relative difference |p/q - 1| over the parameters, with the larger value as p; infinite if a parameter is zero on one side
/// only.
double relative_change(const CoilParameters& a, const CoilParameters& b);

struct CoilTheory {
    double frequency = 0;      ///< Hz
    double radius = 0;         ///< radius of the circle on which the thread's axis comes to rest [m]
    double thread_radius = 0;  ///< radius of the thread where it comes to rest [m]
    double length = 0;         ///< length of the falling thread [m]
};

/// Finds steady coils. Continues from the last coil if the parameters have changed little.
class CoilSolver {
public:
    CoilSolver();
    ~CoilSolver();
    CoilSolver(CoilSolver&&) noexcept;
    CoilSolver& operator=(CoilSolver&&) noexcept;

    /// If all parameters are within a tenth of those of the last answer, the search starts from the last coil. Otherwise, or if that fails,
    /// the solver follows the branch of coils from infinite viscosity, for which there is exactly one coil, through the folds of the branch
    /// to the requested viscosity. If several coils are possible at that viscosity (inertio-gravitational coiling: Ribe, Huppert,
    /// Hallworth, Habibi & Bonn 2006), the first on the branch counts.
    /// @return empty if no coil was found within `most_effort` linear solves, if the radius of the coil would not exceed that of its
    /// thread, or if `give_up` became true
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
