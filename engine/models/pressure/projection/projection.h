#pragma once
/// Incompressible flow by projection: a Poisson equation for the pressure that takes the divergence away (Cummins and Rudman 1999;
/// operators after Lind et al. 2012; docs/physics.md).
#include <optional>

#include "engine/geometry/body_contact.h"
#include "engine/models/pressure/projection/projection_system.h"

namespace whorl {

/// Coupling of the fluid's pressure and free bodies.
///
/// By the flux at a body's layer its velocity counts in the divergence at fluid particle i. V times that flux, Q_i, is also what a pressure
/// at i pushes the body by: force and torque are Q p. With M the bodies' masses and tensors of inertia the system of the projection is
///
///   A + rho_0 Q^T M^-1 Q,
///
/// symmetric and positive as A is, and the step is stable however light the body. The particles are a little off the surface. So Q is
/// slanted by a linear function of the place such that a pressure linear in it pushes as it does on the surface itself: a uniform one not
/// at all, a hydrostatic one with the weight of the fluid displaced.
class PressureOnBodies {
public:
    /// @param walls with its touches @param unknown of the pressure equation; the other particles have p = 0
    void build(const ProjectionSystem& walls, const InteractionContext& context, Read<field::role> role, Span<const char> unknown);
    bool any() const { return !bodies_.empty(); }
    /// Adds rho_0 Q^T M^-1 Q p.
    void add_product(Span<const Real> p, Span<Real> Ap) const;
    /// The velocities after the pressure p over dt [s] and contact; the layer has them, too. add_product() then takes the contacts that
    /// held as bound: their effect elsewhere is left to the next solve.
    void push(Span<const Real> p, double dt, const InteractionContext& context);
    /// Sets the pressure in the ledgers of solids that a probe reads, are closed all around and not free: it acts on them as on bodies.
    /// @param p over the step @returns those solids
    std::vector<std::size_t> write_closed(const ProjectionSystem& walls, const InteractionContext& context, Read<field::role> role,
                                          Span<const Real> p);

private:
    /// Surface of a layer, in the body's own axes.
    struct Surface {
        std::size_t solid;
        std::vector<Index> boundary;
        std::vector<Vec3d> area;  ///< m^2, in 2D m
    };
    using Wrench6 = Eigen::Matrix<double, 6, 1>;  ///< force, torque about the centre
    using Moments = Eigen::Matrix<double, 4, 6>;  ///< sums of (1, x) Q^T
    /// Row of one fluid particle.
    struct Row {
        Index particle;
        Wrench6 Q = Wrench6::Zero();
        double flux = 0;  ///< the sum of its sizes [m^2, in 2D m]
    };
    struct Body {
        Vec3d centre;
        std::vector<Row> rows;
    };
    /// @param volume, own_centre of the solid @param closed written: whether the layer goes all around
    static Surface surface_of(const InteractionContext& context, std::size_t solid, double volume, const Vec3d& own_centre, bool& closed);
    /// @param near particles near the solid
    static Body rows_of(const ProjectionSystem& walls, const Surface& surface, const InteractionContext& context,
                        const std::vector<Index>& near, Read<field::role> role);
    static void add_rows(const ProjectionSystem& walls, std::size_t solid, const InteractionContext& context,
                         const std::vector<Index>& near, Read<field::role> role, Body& body);
    static Moments surface_moments(const Surface& surface, const InteractionContext& context, const std::vector<Index>& near,
                                   const Body& body);
    static void slant(const InteractionContext& context, const Moments& of_surface, Body& body);
    static Wrench6 sum(const Body& body, Span<const Real> p);

    std::vector<Surface> surfaces_;               ///< of the free ones
    std::optional<std::vector<Surface>> closed_;  ///< of those that are not
    BodyVector impulses(Span<const Real> p) const;

    std::vector<Body> bodies_;  ///< all free ones, in the solids' order
    BodyContacts contacts_;     ///< with a clearance of two spacings: the pressure in a thinner film of fluid is not resolved
    double rest_density_ = 0;
};

/// x* = x + dt u and so for the turning: forces act where the bodies come to. With ProjectionDrift.
struct ProjectionBodyDrift {
    std::shared_ptr<ProjectionSystem> system;
    void operator()(const InteractionContext& context) const;
};

/// x = x* + dt/2 (u - u_start). With ProjectionMove.
struct ProjectionBodyMove {
    std::shared_ptr<ProjectionSystem> system;
    void operator()(const InteractionContext& context) const;
};

/// u* = u + (old pressure's share); then, `solves` times, for the remaining divergence:
///
///   sum_j 2 V |W'|/r (p_i - p_j) + air_i p_i = -rho_0 (D u)_i/(theta dt),    u -= theta dt L sum_j V (p_j - p_i) grad W / rho_0
///
/// The field `pressure` is the mean over the step, theta of the new one and (1 - theta) of the old: this moves the fluid. The solved one
/// oscillates: an error of a single step changes sign from step to step and decays as ((1 - theta)/theta)^n.
///
/// D is the trace of the corrected difference gradient over the fluid, and at walls the flux of the normal velocity that the flow has there
/// relative to the wall. Walls have no pressure of their own: leaving them out of the matrix says that no flow goes through them.
class Projection {
public:
    explicit Projection(std::shared_ptr<ProjectionSystem> system) : system_(std::move(system)) {}
    void operator()(const InteractionContext& context, StepReport& report, Read<field::role> role, Update<field::velocity> u,
                    Update<field::pressure> p, Update<field::solved_pressure> solved, Update<field::pressure_acceleration> a);

private:
    /// What the stage works on.
    struct Fields {
        const InteractionContext& context;
        const StepContext& step;
        Read<field::role> role;
        Update<field::velocity> u;
        Update<field::pressure> p;
        Update<field::solved_pressure> solved;
        Update<field::pressure_acceleration> a;
    };
    template <class Kernel>
    void build(const Kernel& W, const Fields& f);
    void find_held(const Fields& f);
    template <class Kernel>
    void set_source(const Kernel& W, const Fields& f, Real dt);
    void take_old_share(const Fields& f, Real share);
    template <class Kernel>
    Vec3 push_of(const Kernel& W, const Fields& f, Index i) const;
    template <class Kernel>
    SolveReport solve(const Kernel& W, const PressurePreconditioner& M, const Fields& f, Real dt, bool first);
    void begin_ledgers(const Fields& f);
    void write_ledgers(const Fields& f);
    void damp_surface(const Fields& f) const;

    std::shared_ptr<ProjectionSystem> system_;
    PressureMatrix matrix_;
    PressureOnBodies on_bodies_;
    ClosedRegions closed_;
    std::vector<char> touches_surface_, beside_held_;
    Column<Real> b_, phi_, of_air_;
};

/// A shift against uneven spacing that takes the flow's values along:
///   dx = -shift_rate s R/2 dt sum V [1 + 0.2 (W/W(d))^4] grad W,   u += (dx.grad) u + dx^2/(2 D) lap u,   s = max |u_i - mean u|
/// At a free surface particles shift along it alone; one with tension is levelled. None shifts into a wall.
struct ProjectionShift {
    std::shared_ptr<ProjectionSystem> system;
    void level_surface(const InteractionContext& context, Read<field::role> role) const;
    void operator()(const InteractionContext& context, Read<field::role> role, Update<field::position> x, Update<field::velocity> u) const;
};

/// The end of the step: x += dt/2 (u - u_start), both including the velocity transported by the shift.
struct ProjectionMove {
    std::shared_ptr<ProjectionSystem> system;
    void operator()(const InteractionContext& context, Read<field::role> role, Read<field::velocity> u, Update<field::position> x) const {
        const ProjectionSystem& s = *system;
        parallel_for(x.size(), [&](Index i) { x[i] += context.step.dt / 2 * (u[i] - s.start_velocity[i]); });
        if (!s.before.empty())
            share_rest(
                s.remainder, context, role, x.values, [&](Index i) { return Vec3(u[i] - s.before[i]); }, s.closed);
    }
};

}  // namespace whorl
