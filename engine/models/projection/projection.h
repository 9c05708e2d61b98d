#pragma once
/// Incompressible flow by projection: a Poisson equation for the pressure that takes the divergence away (Cummins and Rudman 1999;
/// operators after Lind et al. 2012; docs/physics.md).
#include "engine/models/projection/projection_system.h"

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
    template <class Kernel>
    void set_source(const Kernel& W, const Surroundings& around, const Vec3* u, Real dt);
    void damp_surface(const Surroundings& around, Read<field::role> role, Update<field::velocity> u) const;

    std::shared_ptr<ProjectionSystem> system_;
    PressureMatrix matrix_;
    ClosedRegions closed_;
    std::vector<char> touches_surface_;
    Column<Real> b_, phi_;
};

/// The end of the step: x = x* + dt/2 (u - u_start), then a shift against uneven spacing that takes the flow's values along:
///   dx = -shift_rate s R/2 dt sum V [1 + 0.2 (W/W(d))^4] grad W,   u += (dx.grad) u + dx^2/(2 D) lap u,   s = max |u_i - mean u|
/// At a free surface particles shift along it alone.
struct ProjectionMove {
    std::shared_ptr<ProjectionSystem> system;
    void operator()(const Surroundings& around, Read<field::role> role, Update<field::position> x, Update<field::velocity> u) const;
};

}  // namespace whorl
