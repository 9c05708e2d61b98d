#pragma once
/// One step of the coupled solve: its phases in order, and their shared data. Public stages: coupled_solve.h.
#include <algorithm>
#include <cmath>

#include "engine/core/parallel.h"
#include "engine/geometry/solids.h"
#include "engine/models/viscosity/coupled/body_solve.h"
#include "engine/models/viscosity/coupled/coupled_system.h"
#include "engine/models/viscosity/implicit_viscosity.h"
#include "engine/models/viscosity/strain/curvature.h"
#include "engine/particles/step_context.h"

namespace whorl {

/// The unknown part of a velocity: zero for a prescribed particle.
struct Unknowns {
    Span<const std::int16_t> role;

    Vec3 part(Index i, const Vec3& v) const { return role[i] != 0 ? Vec3(Vec3::Zero()) : v; }
    /// Leaves the entries of bodies.
    void restrict_to(Span<Vec3> v) const {
        parallel_for(static_cast<Index>(role.size()), [&](Index i) { v[i] = part(i, v[i]); });
    }
};

struct CoupledStep {
    CoupledSystem& system;
    Read<field::position> x;
    Read<field::role> role;
    Read<field::viscosity> mu;
    Update<field::velocity> u;
    Update<field::pressure> p;
    Update<field::velocity_change> change;
    Update<field::velocity_gradient> G;
    Update<field::aggregate> aggregate;
    Update<field::contact_normal> slip;
    const InteractionContext& context;

    Span<const Real> last_rate{};  ///< shear rate in the last step [1/s]; empty: the viscosity does not depend on it
    double looseness = 1;          ///< factor on the tolerance

    Solids& solids = context.solids;
    const StepContext& step = context.step;

    const CoupledOptions& options = system.options;
    StrainForm& form = system.form;
    const Index n = x.size();
    const Real dt = step.dt, d = step.spacing;
    const double fastest = largest_speed(u.values);  ///< at the start of the step [m/s]

    Unknowns unknowns{role.values};
    BodySolve bodies{};
    std::size_t entries = 0;  ///< of the vectors of the solve: one per particle, then two per free body
    Index free_particles = 0;
    /// Whether fluid at rest starts to bear its weight. It has no multiplier, and particles are not pushed apart or together.
    const bool starts = step.time == 0 && fastest == 0 && step.gravity != Vec3::Zero();
    bool nothing_held = false;  ///< no solid and no nozzle acts, so momentum is conserved
    Column<Vec3> known{};       ///< the part of the velocities that is prescribed [m/s]
    Column<Vec3> solved{};      ///< the unknown part: first the initial guess, then the solution [m/s]
    Column<Mat3> curvature{};   ///< T [1/s]
    Column<Real> divergence{};  ///< s, requested by the step [1/s]
    Column<Real> pressure{};    ///< q [m/s]: the multiplier plus the part of the bulk term that does not depend on u
    Column<Vec3> balancing{};   ///< part of the load that corrects the force of a known pressure [m/s], see balance()
    Column<Vec3> load{};        ///< right-hand side, then the residual until the end of the step [m/s]
    Column<Vec3> work{};

    /// First phase: everything that does not depend on the viscosity.
    void prepare();
    void set_up_form();
    void find_unknowns();
    void set_known_velocities();
    void set_curvature();
    void set_divergence();
    double share_of_push() const;
    void set_up_preconditioner(bool changed);

    /// Second phase, which a flow law repeats with other viscosities. @param again start from `solved`
    void find_velocity(StepReport& report, bool again = false);
    void set_pressure();
    void balance();
    double set_load();
    /// Velocity of a particle after the loads of the step. @param before its velocity at the start
    Vec3 loaded(Index i, const Vec3& before) const {
        Vec3 v = before + dt * step.gravity;
        if (!balancing.empty()) v += balancing[i];
        if (system.friction.acts()) v += system.friction.load[i];
        return v;
    }
    SolveReport solve(double reference, bool again);
    SolveReport solve_with_contact(double reference);
    /// @returns v.y
    double multiply(Span<const Vec3> v, Span<Vec3> y) const {
        const double product = form.apply(v, y, [this](Index i, const Vec3& of_i) { return unknowns.part(i, of_i); });
        if (bodies.in_contact()) bodies.free_part_of_forces(y.subspan(static_cast<std::size_t>(n)));
        return product;
    }
    /// z = M r @returns r.z
    double precondition(Span<const Vec3> r, Span<Vec3> z) const {
        const double product = system.preconditioner(r, z);
        if (bodies.in_contact()) bodies.free_part(z.subspan(static_cast<std::size_t>(n)));
        return product;
    }
    /// sqrt(r.M r); leaves M r in `work`.
    double preconditioned_norm(Span<const Vec3> r) { return std::sqrt(std::max(0.0, precondition(r, work))); }
    SolveLimits limits() const;
    void descend(Span<const Vec3> way);
    void descend_along_last_change();
    void let_go();
    /// Whether the forces on solids are needed: for probes, and for the energy of free bodies.
    bool writes_ledgers() const { return solids.any_probed() || bodies.any(); }

    void find_gradient();
    void find_shear_rates(Span<Real> gamma);
    void lose_energy();

    /// Last phase.
    void finish(StepReport& report);
    void keep_momentum();
    void keep_volume(SolveReport& report);
    Real missing_volume(Index i) const { return role[i] == 0 ? divergence[i] - form.divergence(i, G[i]) : Real(0); }
    void raise_multiplier(Column<Real>& more, Real kept, SolveReport& report);
    void take_over();
    void move_bodies();
    void write_ledgers();
    void count_pushes(StepReport& report);
    void release_slipping();
};

}  // namespace whorl
