#pragma once
/// Incompressible flow by projection: a Poisson equation for the pressure that removes the divergence (Cummins and Rudman 1999;
/// operators after Lind et al. 2012; docs/physics.md).
#include <optional>

#include "engine/geometry/body_contact.h"
#include "engine/models/pressure/projection/projection_system.h"

namespace whorl {

/// Coupling of the fluid's pressure and free bodies.
///
/// The velocity of a body contributes to the divergence at fluid particle i by the fluxes at the body's boundary particles. Q_i is V times
/// these fluxes. It is also the force and torque on the body per pressure at i, so pressures p exert Q p. With M the masses and tensors of
/// inertia of the bodies and A the matrix without bodies, the matrix of the projection is
///
///   A + rho_0 Q^T M^-1 Q.
///
/// It is symmetric and positive, as A is, and the step is stable for any mass of the body. The fluid particles do not lie on the body's
/// surface. So Q is corrected by a linear function of position, such that a pressure that is linear in position exerts the same force as on
/// the surface. A uniform pressure then exerts no force, and a hydrostatic pressure the weight of the displaced fluid.
class PressureOnBodies {
public:
    /// @param walls with its touches set @param unknown by particle: whether its pressure is an unknown; other particles have p = 0
    void build(const ProjectionSystem& walls, const InteractionContext& context, Read<field::role> role, Span<const char> unknown);
    bool any() const { return !bodies_.empty(); }
    /// Adds rho_0 Q^T M^-1 Q p.
    void add_product(Span<const Real> p, Span<Real> Ap) const;
    /// Sets the velocities of the bodies and of their boundary particles after the pressure p over dt [s] and contact. add_product() then
    /// treats the contacts that held as fixed. The next solve accounts for the effect of these contacts on the fluid and other bodies.
    void push(Span<const Real> p, double dt, const InteractionContext& context);
    /// For closed solids that are not free and whose ledger a probe reads: replaces the pressure in the ledger. The pressure then acts on
    /// them as on free bodies. @param p mean over the step @returns these solids
    std::vector<std::size_t> write_closed(const ProjectionSystem& walls, const InteractionContext& context, Read<field::role> role,
                                          Span<const Real> p);

private:
    /// Surface of a solid, in the solid's own axes.
    struct Surface {
        std::size_t solid;
        std::vector<Index> boundary;
        std::vector<Vec3d> area;  ///< m^2, in 2D m
    };
    using Wrench6 = Eigen::Matrix<double, 6, 1>;  ///< force, torque about the centre
    using Moments = Eigen::Matrix<double, 4, 6>;  ///< sums of (1, x) Q^T
    /// Row of Q of one fluid particle.
    struct Row {
        Index particle;
        Wrench6 Q = Wrench6::Zero();
        double flux = 0;  ///< sum of |V flux| [m^2, in 2D m]
    };
    struct Body {
        Vec3d centre;
        std::vector<Row> rows;
    };
    /// @param volume, own_centre of the solid @param closed written: whether the boundary particles surround the solid
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

    std::vector<Surface> surfaces_;               ///< surfaces of the free bodies
    std::optional<std::vector<Surface>> closed_;  ///< surfaces of closed solids that are not free
    BodyVector impulses(Span<const Real> p) const;

    std::vector<Body> bodies_;  ///< all free bodies, in the order of the solids
    BodyContacts contacts_;     ///< with a clearance of two spacings, because the pressure in a thinner film is not resolved
    double rest_density_ = 0;
};

/// x* = x + dt u, and likewise the rotation, so that forces act at the new positions of the bodies. Runs with ProjectionDrift.
struct ProjectionBodyDrift {
    std::shared_ptr<ProjectionSystem> system;
    void operator()(const InteractionContext& context) const;
};

/// x = x* + dt/2 (u - u_start). Runs with ProjectionMove.
struct ProjectionBodyMove {
    std::shared_ptr<ProjectionSystem> system;
    void operator()(const InteractionContext& context) const;
};

/// First u changes by the share (1 - theta) of the old pressure. Then, `solves` times, for the remaining divergence:
///
///   sum_j 2 V |W'|/r (p_i - p_j) + air_i p_i = -rho_0 (D u)_i/(theta dt),    u -= theta dt L sum_j V (p_j - p_i) grad W / rho_0
///
/// air_i: ProjectionSystem::air; L: LinearSums::correction. The field `pressure` is the mean over the step, theta times the new pressure
/// plus (1 - theta) times the old pressure. This mean moves the fluid. The solved pressure oscillates: an error of one step changes sign
/// from step to step, and after n steps has decayed as ((1 - theta)/theta)^n.
///
/// D is the trace of the corrected difference gradient over the fluid. At walls D also contains the flux of the flow's normal velocity
/// relative to the wall. Walls have no unknown pressure and no coefficient in the matrix, so no fluid flows through them.
class Projection {
public:
    explicit Projection(std::shared_ptr<ProjectionSystem> system) : system_(std::move(system)) {}
    void operator()(const InteractionContext& context, StepReport& report, Read<field::role> role, Update<field::velocity> u,
                    Update<field::pressure> p, Update<field::solved_pressure> solved, Update<field::pressure_acceleration> a);

private:
    /// Arguments of the stage.
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
    /// Preconditioner of matrix_. In a full room it is that of an earlier step for up to `kept_most` steps, in which no particle moves by
    /// more than a spacing.
    const PressurePreconditioner& preconditioner(const StepContext& step);
    template <class Kernel>
    void set_source(const Kernel& W, const Fields& f, Real dt);
    void take_old_share(const Fields& f, Real share);
    template <class Kernel>
    Vec3 push_of(const Kernel& W, const Fields& f, Index i) const;
    template <class Kernel>
    SolveReport solve(const Kernel& W, const PressurePreconditioner& M, const Fields& f, Real dt, bool first);
    void begin_ledgers(const Fields& f);
    void write_ledgers(const Fields& f);
    void damp_unresolved(const Fields& f) const;

    std::shared_ptr<ProjectionSystem> system_;
    PressureMatrix matrix_;
    PressureOnBodies on_bodies_;
    ClosedRegions closed_;
    static constexpr int kept_most = 4;  ///< divides the number of steps between two sorts of the particles
    PressurePreconditioner kept_;
    int kept_steps_ = 0;   ///< number of steps since kept_ was set up
    Index kept_for_ = -1;  ///< number of particles then
    std::vector<char> touches_surface_, beside_held_;
    Column<Real> b_, phi_, of_air_;
};

/// Shifts particles towards even spacing and gives them the velocity at the new position:
///   dx = -shift_rate v (R/2) dt sum V [1 + 0.2 (W/W(d))^4] grad W,   u += (dx.grad) u + dx^2/(2 D) lap u,   v = max |u_i - mean u|
/// At a free surface particles shift only along the surface. A surface with tension is also levelled by level_surface(). No particle shifts
/// into a wall.
struct ProjectionShift {
    std::shared_ptr<ProjectionSystem> system;
    void level_surface(const InteractionContext& context, Read<field::role> role) const;
    void operator()(const InteractionContext& context, Read<field::role> role, Update<field::position> x, Update<field::velocity> u) const;
};

/// End of the step: x += dt/2 (u - u_start). Both velocities include the change by the shift.
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
