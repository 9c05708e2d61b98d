#pragma once
/// Incompressible flow by projection: a Poisson equation for the pressure that takes the divergence away (Cummins and Rudman 1999;
/// operators after Lind et al. 2012; docs/physics.md).
#include "engine/models/projection/projection_bodies.h"

namespace whorl {

/// u* = u + (old pressure's share); then, `solves` times, for what divergence is left:
///
///   sum_j 2 V |W'|/r (p_i - p_j) + air_i p_i = -rho_0 (D u)_i/(theta dt),    u -= theta dt L sum_j V (p_j - p_i) grad W / rho_0
///
/// The field `pressure` is the mean over the step, theta of the new one and (1 - theta) of the old: what moves the fluid. The solved one
/// rings: what a single step does to it changes sign from step to step and dies as ((1 - theta)/theta)^n.
///
/// D is the trace of the corrected difference gradient over the fluid, and at walls the flux of the normal velocity that the flow has there
/// relative to the wall. Walls have no pressure of their own: leaving them out of the matrix says that no flow goes through them.
class Projection {
public:
    explicit Projection(std::shared_ptr<ProjectionSystem> system) : system_(std::move(system)) {}
    void operator()(const Surroundings& around, StepReport& report, Read<field::role> role, Update<field::velocity> u,
                    Update<field::pressure> p, Update<field::solved_pressure> solved, Update<field::pressure_acceleration> a);

private:
    template <class Kernel>
    void build(const Kernel& W, const Surroundings& around, Read<field::role> role);
    void find_held(const FluidPairs& pairs, Read<field::role> role);
    template <class Kernel>
    void set_source(const Kernel& W, const Surroundings& around, const Vec3* u, Real dt);
    void take_old_share(const Surroundings& around, Real share, Read<field::role> role, Update<field::velocity> u,
                        Update<field::pressure> p, Read<field::solved_pressure> solved, Update<field::pressure_acceleration> a);
    template <class Kernel>
    Vec3 push_of(const Kernel& W, const Surroundings& around, Read<field::role> role, Index i) const;
    template <class Kernel>
    SolveReport solve(const Kernel& W, const PressurePreconditioner& M, const Surroundings& around, Real dt, bool first,
                      Read<field::role> role, Update<field::velocity> u, Update<field::solved_pressure> solved,
                      Update<field::pressure_acceleration> a);
    void begin_ledgers(const Surroundings& around, Read<field::role> role, Update<field::velocity> u,
                       Update<field::pressure_acceleration> a);
    void write_ledgers(const Surroundings& around, Read<field::role> role, Update<field::pressure> p);
    void damp_surface(const Surroundings& around, Read<field::role> role, Update<field::velocity> u) const;

    std::shared_ptr<ProjectionSystem> system_;
    PressureMatrix matrix_;
    PressureOnBodies on_bodies_;
    ClosedRegions closed_;
    std::vector<char> touches_surface_, beside_held_;
    Column<Real> b_, phi_, of_air_;
};

/// The end of the step: x = x* + dt/2 (u - u_start), then a shift against uneven spacing that takes the flow's values along:
///   dx = -shift_rate s R/2 dt sum V [1 + 0.2 (W/W(d))^4] grad W,   u += (dx.grad) u + dx^2/(2 D) lap u,   s = max |u_i - mean u|
/// At a free surface particles shift along it alone; one with tension is levelled.
struct ProjectionMove {
    std::shared_ptr<ProjectionSystem> system;
    void level_surface(const Surroundings& around, Read<field::role> role) const;
    void operator()(const Surroundings& around, Read<field::role> role, Update<field::position> x, Update<field::velocity> u) const;
};

}  // namespace whorl
