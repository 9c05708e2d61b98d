#pragma once
/// Incompressible pressure as a constraint: no density exceeds the rest density (docs/physics.md 3).
///
/// Stages of a step, in order: Density (if the viscosity needs one), Gravity, (forces), Kick, (viscosity; if implicit, between
/// ExpectForce and ForgetForce), DampUnresolved, ConstraintPressure, (TakeForce), Move, PushOutOfSolids.
#include "engine/models/pressure/body_rows.h"
#include "engine/models/pressure/pressure_matrix.h"
#include "engine/models/pressure/pressure_options.h"
#include "engine/particles/interaction_context.h"

namespace whorl {

namespace field {
struct constraint_pressure {
    using type = Real;
    static constexpr std::string_view name = "constraint_pressure", unit = "Pa",
                                      meaning = "multiplier of the constraint, from each particle's own sums alone";
};
}  // namespace field

/// A = D D^T restricted to the particles that press; symmetric, positive semi-definite.
///   A_ik = D_i.D_k (D_i.M^-1 D_k if free bodies have columns, body_rows.h)
///   Row D_i contains own_i at i and -f_i g_ij at the free neighbours j (symbols: DensityRate).
/// A row extends to the neighbours' neighbours, so A is applied as two passes over the pairs.
struct ConstraintMatrix {
    const DensityRate& D;
    std::vector<char> presses;     ///< 1: an unknown of the current solve
    mutable Column<Padded> force;  ///< D^T q of the last push()
    Span<const Vec3> x;            ///< positions
    Real spacing = 0;
    const BodyRows* bodies = nullptr;  ///< columns of D that belong to free bodies
    Index size() const { return D.size(); }
    void push(Span<const Real> q) const { D.transposed(q, force); }
    /// Aq = D force, for the q of the last push().
    void rates(Span<const Real> q, Span<Real> Aq) const {
        D.apply(force, presses, Aq);
        if (bodies) bodies->add_product(q, presses, Aq);
    }
    void multiply(Span<const Real> q, Span<Real> Aq) const { push(q), rates(q, Aq); }
};

/// Sets up a preconditioner for the current `presses`. Called once per step, and again if many particles start or stop to press. The
/// returned function reads `presses` at each call.
using ConstraintPreconditionerSetup = std::function<PressurePreconditioner(const ConstraintMatrix&)>;
/// z = r/diagonal
PressurePreconditioner diagonal_scaling(const ConstraintMatrix& matrix);
/// z = r
PressurePreconditioner constraint_unpreconditioned(const ConstraintMatrix& matrix);

/// Finds q = dt p/rho^2 with   q >= 0,   rho_i + dt (D (u - D^T q))_i + e_i <= rho_0,   and q_i = 0 if the density stays below rho_0; then
/// u -= D^T q. e is the error of the linear prediction, rho(x + dt v) - rho(x) - dt D v, with v = u - D^T q for the q of the last step. If
/// rho_i exceeds rho_0, the step corrects only a share of the excess. The solve may lose energy and never gains any. Free surfaces, single
/// particles, closed boxes and slots need no special case: A q = b is solvable if any particle or body can move. If fluid fills a periodic
/// domain, none can, and densities are kept equal instead.
class ConstraintPressure {
public:
    explicit ConstraintPressure(const PressureOptions& options, ConstraintPreconditionerSetup preconditioner = diagonal_scaling)
        : options_(options), preconditioner_(std::move(preconditioner)) {}
    void operator()(const InteractionContext& context, StepReport& report, Read<field::role> role, Write<field::density> rho,
                    Update<field::velocity> u, Update<field::constraint_pressure> multiplier, Write<field::pressure> p);

private:
    /// Solves A q >= b, q >= 0, q.(A q - b) = 0. A.force must be D^T q at the start; at the end it is D^T q for the new q.
    SolveReport solve(ConstraintMatrix& A, const StepContext& step, Span<Real> q);
    /// Scales q so that q.(b - A q) = 0, for residual_ = A q and matrix.force = D^T q; the pressures then support the weight of the fluid.
    /// Otherwise a residual common to all particles could meet the tolerance, and still be most of the density that a short step adds in a
    /// deep fluid.
    void scale_to_work(ConstraintMatrix& matrix, Span<Real> q);
    /// Sums over the particles that press in a round of the active set, and over those that join it.
    struct ActiveSet {
        double squares = 0;              ///< sum of the squared residuals of these particles
        Index pressed = 0, joining = 0;  ///< particles that already press; compressed particles that do not yet
        void operator+=(const ActiveSet& o) { squares += o.squares, pressed += o.pressed, joining += o.joining; }
    };
    /// Sets matrix.presses, and `rest` to b - A q there. @param about_full if more particles join than press, particles with a residual b -
    /// A q above -about_full join, too [kg/(m^3 s)]
    ActiveSet choose(ConstraintMatrix& matrix, Span<const Real> q, Real about_full, Span<Real> rest) const;
    double tolerance_of_rates(const ConstraintMatrix& matrix, double worst_rate) const;
    double correction() const { return options_.correction.value_or(0.5); }
    /// Fraction of a density above rho_0 (of any density error, if the domain is `filled`) that the step corrects.
    Real correction_share(bool slowly) const {
        return static_cast<Real>(slowly || options_.slow_correction ? 0.4 * correction() : correction());
    }
    /// Rate at which a density rho has to approach `target` [kg/(m^3 s)]. @param time correction_time() [s]
    Real correction_rate(Real rho, Real target, bool filled, bool at_body, const StepContext& step, Real time) const;
    /// Time in which a density error is corrected [s]: the step. Near free bodies the time is at least 0.4 d/sqrt(u^2 + g d), with u
    /// the largest speed of the fluid. Otherwise the correction of a thin film would throw up a heavy body on the film, the faster the
    /// shorter the step, and the pressure that throws the body would shorten the next step.
    Real correction_time(Span<const Vec3> u, const StepContext& step) const;
    /// Factor on the density correction. It limits the speed at which this correction moves the fluid as a whole. Correcting a density
    /// error e common to a fluid of size L moves the fluid's surface by e L. In a short step dt this throws the surface up (a tank 1 m deep
    /// with e = 9e-4, a lattice in 2D, at 2 m/s if dt is 0.1 ms). So the mean error is corrected with a velocity of at most 0.03 (sqrt(g L)
    /// + root mean square of the speed). Applies if the scene has solids.
    /// @returns 1 if the correction is slower than that, or if the fluid has neither motion nor weight
    Real calm_share(Span<const Real> rho, Span<const Vec3> u, const StepContext& step) const;
    /// Adds e/dt to b_. @param force D^T q
    void add_bend(const WallImage& wall, const InteractionContext& context, Span<const Real> rho, Span<const Vec3> u, Span<const Real> q,
                  Span<const Padded> force);
    bool has_free_surface(Span<const Real> q, const StepContext& step) const;
    /// Limits the pressure of fluid without a free surface that a solid squeezes. No particle can give way there. A uniform pressure
    /// accelerates no particle, so it would grow without bound. If the pressure would move 95 % of the particles by more than d/4 within
    /// the step, sqrt(p/rho) dt > d/4, it is limited to p = rho (d/(4 dt))^2. The fluid is then compressed, in steps of a usual length.
    /// @returns whether the pressure was limited
    static bool limit_level(Span<Real> q, const StepContext& step);
    std::string squeezed_text(const InteractionContext& context, Span<const Real> q) const;
    /// Effect of the images in one wall on particle i, over the pairs in which i is nearer to the wall than the other particle. The
    /// opposite impulse is distributed over the boundary particles of the wall, with weights that decrease with their distance from i.
    struct ByImages {
        Vec3 normal;
        Real push;  ///< change of velocity along the normal [m/s]
        Vec3 back;  ///< from the point at which the push acts to i [m]
        Real weights;
        bool acts_on(const Vec3& n) const { return n.dot(normal) > Real(0.99); }
        static Real weight(Real reach, Real distance) { return (reach - distance) * (reach - distance); }
    };
    std::vector<ByImages> pushes_of_images(const InteractionContext& context, Span<const Real> q, Index i) const;
    /// Writes the ledger entries of solids that are not unknowns: u_i -= q_i f_i rho_i dw_i/dx_i, and the forces of images.
    void write_ledgers(const WallImage& wall, const InteractionContext& context, Read<field::role> role, Span<const Real> rho,
                       Span<const Real> q) const;
    /// Pressures for frames and probes, from the forces of q. A particle's part of the stress is
    ///   s_i = rho_i/dt (1/2 sum_j |c_ij| (f_i q_i + f_j q_j) r_ij r_ij^T + f_i q_i rho_i sum_s h_is |grad w_is| n_s^T),   h_is height
    ///   above s.
    /// The pressure is the mean of s_i over all directions, at walls the normal component of s_i, because layers press less along a wall
    /// than across it.
    void find_pressures(const WallImage& wall, const InteractionContext& context, Span<const Real> rho, Span<const Real> q,
                        Span<Real> p) const;
    SolveReport solve_filled(ConstraintMatrix& A, const StepContext& step, double mean_rate, Real fastest, Span<Real> q);

    PressureOptions options_;
    ConstraintPreconditionerSetup preconditioner_;
    DensityRate D_;
    BodyRows bodies_;
    Column<Real> b_, residual_;
};

/// Whether no particle can give way, because every axis is periodic and the volumes of particles and free bodies fill the domain.
bool fills_periodic_domain(const InteractionContext& context, Index n);

/// Limit of the time step from pressure: cfl d / sqrt(p/rho_0) [s], with p the mean pressure over the fluid under pressure. Displacements
/// within a step rotate the forces between neighbours. In steps longer than twice this limit (at cfl 0.4) a column at rest becomes
/// unstable, whatever the solver's tolerance.
double pressure_step(double cfl, double spacing, double rest_density, Span<const Real> pressure);

}  // namespace whorl
