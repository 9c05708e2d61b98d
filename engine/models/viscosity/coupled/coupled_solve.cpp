#include "engine/models/viscosity/coupled/coupled_solve.h"

#include <algorithm>
#include <limits>

#include "engine/core/parallel.h"
#include "engine/math/conjugate_gradients.h"
#include "engine/models/bodies/reaction.h"
#include "engine/models/viscosity/implicit_viscosity.h"
#include "engine/particles/step_context.h"

namespace whorl {
namespace {

/// The unknown part of a velocity: zero for a prescribed particle.
struct Unknowns {
    Span<const std::int16_t> role;

    Vec3 part(Index i, const Vec3& v) const { return role[i] != 0 ? Vec3(Vec3::Zero()) : v; }
    void restrict_to(Span<Vec3> v) const {
        parallel_for(static_cast<Index>(v.size()), [&](Index i) { v[i] = part(i, v[i]); });
    }
};

}  // namespace

void CoupledNeighbourhood::operator()(Read<field::position> x, Read<field::role> role, Write<field::density> density,
                                      Update<field::held> held, Update<field::contact_normal> slip, const Solids& solids,
                                      const StepContext& step) const {
    CoupledSystem& s = *system;
    s.rows.build(x.values, role.values, step.domain, step.spacing, s.options, {solids, step.dt, held.values, slip.values});
    parallel_for(x.size(), [&](Index i) { density[i] = step.rest_density * s.rows.neighbourhood[i].density; });
}

void CoupledGradient::operator()(Read<field::velocity> u, Write<field::velocity_gradient> G, const Solids& solids,
                                 const StepContext& step) const {
    CoupledRows& rows = system->rows;
    const bool turns =
        std::any_of(solids.all.begin(), solids.all.end(), [](const Solid& s) { return s.pose.angular_velocity != Vec3::Zero(); });
    const auto set_walls = [&](Real dt) {
        if (!turns) return;  // the velocity does not depend on the sign of dt
        for (RowBlock& block : rows.blocks)
            for (WallPoint& wall : block.walls) wall.velocity = velocity_over(solids.all[wall.solid], wall.position, dt);
    };
    set_walls(-step.dt);  // mean over the last step, like the velocities of the particles
    velocity_gradients(rows, step.spacing, u.values, G.values);
    set_walls(step.dt);
    parallel_for(u.size(), [&](Index i) {
        if (rows.neighbourhood[i].unresolved > 0) G[i] = turned_rigidly(G[i], rows.resolved(i));
    });
}

namespace {

/// One step of the solve: its phases in order, and their shared data.
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
    Solids& solids;
    const StepContext& step;

    Span<const Real> last_rate{};  ///< shear rate in the last step [1/s]; empty: the viscosity does not depend on it
    double looseness = 1;          ///< factor on the tolerance

    const CoupledOptions& options = system.options;
    StrainForm& form = system.form;
    const Index n = x.size();
    const Real dt = step.dt, d = step.spacing;
    const double fastest = largest_speed(u.values);  ///< at the start of the step [m/s]

    Unknowns unknowns{role.values};
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

    void set_up_form() {
        system.friction.set(system.rows, mu.values, step);
        form.set(system.rows, mu.values, dt, step.rest_density, d, options);
        form.set_friction(system.friction.coefficient);
    }

    void find_unknowns() {
        for (Index i = 0; i < n; ++i) free_particles += role[i] == 0;
        nothing_held = free_particles == n && system.rows.walls == 0;
    }

    /// Sets the velocities of nozzles and solids.
    void set_known_velocities() {
        known.resize(n), solved.resize(n), load.resize(n), work.resize(n);
        parallel_for(n, [&](Index i) {
            known[i] = Vec3::Zero();
            if (role[i] > 0) u[i] = solids.all[role[i] - 1].velocity_at(x[i]);
            if (role[i] != 0) known[i] = u[i];
        });
    }

    /// Sets the curvature in the directions that the neighbours resolve; 0 for particles that are not free, whose motion is prescribed.
    void set_curvature() {
        curvature.resize(n);
        parallel_for(n, [&](Index i) {
            curvature[i].setZero();
            if (role[i] != 0) return;
            curvature[i] = curvature_strain(G[i], dt);
            if (system.rows.neighbourhood[i].unresolved > 0) {
                const Mat3 P = system.rows.resolved(i);
                curvature[i] = P * curvature[i] * P;
            }
        });
    }

    /// Sets the requested rate of volume change, s_i. Compressed particles separate. Loose particles under pressure approach, as far as the
    /// options allow. Otherwise s_i = tr T keeps the volume, because the rate of volume change in the middle of the move is tr D - tr T.
    void set_divergence() {
        divergence.resize(n);
        const double fastest_push = options.fastest_push * (fastest / d + std::sqrt(step.gravity.norm() / d));
        const double meeting = system.rows.dimensions() == 2 ? 1 : options.meeting_in_space;
        const auto loose = [&](const Neighbourhood& context, double lacking) {
            if (options.vessel < 0) return meeting * lacking * std::clamp(2 - context.surface / options.no_surface, 0.0, 1.0);
            const double surface = std::min(static_cast<double>(context.surface), options.even_surface);
            return std::min(0.0, lacking + 0.85 * std::max(0.0, surface - options.no_surface));  // without the deficit of a surface
        };
        parallel_for(n, [&](Index i) {
            const Neighbourhood& context = system.rows.neighbourhood[i];
            double compressed = context.density - 1;
            // Fluid under tension is never drawn together, because a thread would creep without end.
            if (compressed < 0) compressed = p[i] > 0 ? loose(context, compressed) : 0;
            const double most = last_rate.empty() ? fastest_push : std::min(fastest_push, options.push_of_shear * last_rate[i]);
            const double pushed = starts ? 0 : std::clamp(options.push * compressed / dt, -most, most);
            divergence[i] = static_cast<Real>(pushed) + curvature[i].trace();
        });
    }

    void set_pressure() {
        pressure.resize(n);
        const std::vector<Real>& known_pressure = *system.known_pressure;
        const bool any_known = known_pressure.size() == x.values.size();
        parallel_for(n, [&](Index i) {
            pressure[i] = form.coefficients(i).bulk * d * divergence[i] +
                          system.rows.neighbourhood[i].volume * dt * (p[i] + (any_known ? known_pressure[i] : 0)) / (step.rest_density * d);
        });
    }

    /// @param changed the viscosities differ from those of the last solve
    void set_up_preconditioner(bool changed) {
        TwoLevel& M = system.preconditioner;
        const bool coarse = options.diagonal && free_particles >= options.fewest_for_coarse;
        if (!coarse) M.clear();
        else if (M.due(step.at_frame_time, options.refresh_every))
            M.refresh(form, x.values, role.values, options, step.domain, d, aggregate.values), changed = false;
        M.set(form, x.values, role.values, step.domain, d, aggregate.values);
        if (changed) M.factor(form);
        if (!options.diagonal) M.be_identity();
    }

    /// Velocity of a particle after the loads of the step. @param before its velocity at the start
    Vec3 loaded(Index i, const Vec3& before) const {
        Vec3 v = before + dt * step.gravity;
        if (!balancing.empty()) v += balancing[i];
        if (system.friction.acts()) v += system.friction.load[i];
        return v;
    }

    /// Corrects the force of the pressure in a vessel that turns. Its fluid has the pressure p_0 = rho (level + g.x + rate^2 r^2/2), with
    /// the rate from the fluid's angular momentum. The force -grad p_0 has errors in the rows of disordered particles and next to walls,
    /// which would drive a vortex that lifts the edge. Away from surfaces (c < 0.2, fading to 0.4; the surface of a lattice has 0.31) the
    /// load gets the exact force instead.
    void balance() {
        if (options.vessel < 0) return;
        using Eigen::Vector2d;
        const auto mean = [&](const auto& of) {  // (sum of the first component)/(sum of the second)
            const Vector2d sum = parallel_sum(n, Vector2d(0, 0), [&](Index i) { return role[i] == 0 ? of(i) : Vector2d(0, 0); });
            return static_cast<Real>(sum[1] > 0 ? sum[0] / sum[1] : 0.0);
        };
        const auto inside = [&](Index i) { return std::clamp(2 - system.rows.neighbourhood[i].surface / Real(0.2), Real(0), Real(1)); };
        VesselRotation& rotation = system.rotation;
        rotation = {solids.all[options.vessel].centre().cast<Real>(), -step.gravity.normalized()};
        const auto arm = [&](Index i) { return rotation.arm(x[i]); };
        const Real rate = rotation.rate = mean([&](Index i) { return Vector2d(arm(i).dot(u[i]), arm(i).squaredNorm()); });
        const auto height = [&](Index i) { return step.gravity.dot(x[i]) + rate * rate * arm(i).squaredNorm() / 2; };
        const Real level = mean([&](Index i) { return Vector2d(inside(i) * (p[i] / step.rest_density - height(i)), inside(i)); });
        Column<Real> q(n);
        balancing.resize(n);
        parallel_for(n, [&](Index i) {
            q[i] = system.rows.neighbourhood[i].volume * dt / d * std::max(Real(0), height(i) + level);
            balancing[i] = dt * (step.gravity - rotation.acceleration(x[i]));
        });
        form.add_stress(q, {}, balancing);
        parallel_for(n, [&](Index i) { balancing[i] *= -inside(i); });
    }

    /// Sets the right-hand side.
    /// @returns the reference for its residual: the norm of the loads on the fluid, without the large forces by which nozzles and solids
    /// hold their neighbours. It is at least 3 % of the norm with these forces, for a fluid at rest that only moving solids drag along
    double set_load() {
        parallel_for(n, [&](Index i) { load[i] = loaded(i, u[i]); });
        form.add_stress(pressure, curvature, load);
        unknowns.restrict_to(load);
        const double reference = preconditioned_norm(load);
        if (nothing_held) return reference;
        form.apply(known, work, true);
        parallel_for(n, [&](Index i) { load[i] -= unknowns.part(i, work[i]); });
        return std::max(reference, 0.03 * preconditioned_norm(load));
    }

    /// Frees the arrays that the load now includes, unless release_slipping() or a ledger needs them.
    void let_go() {
        if (!system.rows.any_slip && !solids.any_probed()) Column<Mat3>().swap(curvature), Column<Real>().swap(pressure);
    }

    /// @returns v.y
    double multiply(Span<const Vec3> v, Span<Vec3> y) const {
        return form.apply(v, y, [this](Index i, const Vec3& product) { return unknowns.part(i, product); });
    }

    /// sqrt(r.M r); leaves M r in `work`.
    double preconditioned_norm(Span<const Vec3> r) { return std::sqrt(std::max(0.0, system.preconditioner(r, work))); }

    /// Errors of slow motions persist from step to step and add up. So the tolerance applies to steps in which the fastest fluid moves by
    /// 0.4 d, and is reduced in proportion in shorter steps. The factor is at least 0.03, because in slow fluid errors decay.
    SolveLimits limits() const {
        const double share = std::clamp(dt * fastest / (0.4 * d), 0.03, 1.0);
        return {looseness * share * options.limits.tolerance, options.limits.max_iterations};
    }

    /// Solves by conjugate gradients, starting from the last velocity plus 0.9 times its last change. @param again start from `solved`
    SolveReport solve(double reference, bool again) {
        const auto A = [this](Span<const Vec3> v, Span<Vec3> y) { return multiply(v, y); };
        const TwoLevel& M = system.preconditioner;
        if (!again) parallel_for(n, [&](Index i) { solved[i] = unknowns.part(i, u[i] + Real(0.9) * change[i]); });
        if (!(reference > 0)) return conjugate_gradients<Vec3>(A, M, load, solved, limits(), ResidualNorm::preconditioned);
        multiply(solved, work);
        parallel_for(n, [&](Index i) { load[i] -= work[i]; });  // the residual
        if (preconditioned_norm(load) > reference) {
            descend_along_last_change();
            M(load, work);
        }
        const SolveReport report =
            conjugate_gradients_from<Vec3>(A, M, load, solved, limits(), ResidualNorm::preconditioned, reference, work);
        if (!system.rows.any_slip) return report;
        // Removes the momentum of the residual. Otherwise the motion of sliding fluid as a whole would be too small by the tolerance.
        Column<Vec3> rest(n);
        parallel_for(n, [&](Index i) { solved[i] += rest[i] = unknowns.part(i, M.coarse(i)); });
        if (!solids.any_probed()) return report;
        multiply(rest, work);
        parallel_for(n, [&](Index i) { load[i] -= work[i]; });
        return report;
    }

    /// @param again start from `solved`
    void find_velocity(StepReport& report, bool again = false) {
        set_pressure();
        balance();
        const double reference = set_load();
        report.solves.push_back({SolveKind::coupled, solve(reference, again)});
    }

    /// If no solid or nozzle acts: minimises E along the solution u without its rigid motion. Then u.(A u - b) = 0, so without loads |u| is
    /// at most that of the velocities before, even if the solve is unfinished.
    void lose_energy() {
        if (!nothing_held) return;
        Column<Vec3> bent(n);
        std::copy(solved.begin(), solved.end(), work.begin());
        RigidMotions(x.values, !step.domain.any_periodic()).remove(work);
        const double stiffness = multiply(work, bent);
        if (!(stiffness > 0) || !std::isfinite(stiffness)) return;
        const Real far = static_cast<Real>(dot<Vec3>(work, load) / stiffness);
        parallel_for(n, [&](Index i) {
            solved[i] += far * work[i];
            load[i] -= far * bent[i];
        });
    }

    /// Sets gamma of the solution. @param gamma sqrt(2 D:D) of the deviator of D - T [1/s]
    void find_shear_rates(Span<Real> gamma) {
        parallel_for(n, [&](Index i) { work[i] = known[i] + solved[i]; });
        form.gradient(work, G.values);
        parallel_for(n, [&](Index i) {
            const Mat3 in = system.rows.neighbourhood[i].unresolved > 0 ? Mat3(system.rows.resolved(i) * G[i]) : G[i];
            gamma[i] = shear_rate((in + in.transpose()) / 2 - curvature[i], system.rows.dimensions());
        });
    }

    void prepare() {
        set_up_form();
        find_unknowns();
        set_known_velocities();
        set_curvature();
        set_divergence();
    }

    void finish(StepReport& report) {
        keep_momentum();
        keep_volume(report.solves.back().report);
        take_over();
        write_ledgers();
        count_pushes(report);
        release_slipping();
    }

    /// Replaces a bad initial guess (after an abrupt change of velocity or a landing): minimises the energy along the last step's change of
    /// velocity, and updates the residual.
    void descend_along_last_change() {
        Column<Vec3> way(change.values.begin(), change.values.end()), bent(way.size());
        unknowns.restrict_to(way);
        const double stiffness = multiply(way, bent);
        if (!(stiffness > 0) || !std::isfinite(stiffness)) return;
        const Real far = static_cast<Real>(dot<Vec3>(way, load) / stiffness);
        parallel_for(n, [&](Index i) {
            solved[i] += far * way[i];
            load[i] -= far * bent[i];
        });
    }

    /// If fluid can leave only through a narrow opening (a piston before a slit, the first steps under weight), one update of the
    /// multiplier per step gives far too little pressure, and the volume of the fluid as a whole changes. In that case runs conjugate
    /// gradients for the multiplier, preconditioned by lambda, with a solve for the velocities in each iteration. If these iterations do
    /// not halve the mean error, or raise the mean square error to more than four times, the fluid has no way out, and the solution from
    /// before is restored.
    void keep_volume(SolveReport& report) {
        constexpr double tolerated = 5e-4;  // mean relative change of volume in a step
        constexpr double as_a_whole = 0.5;  // mean over root mean square; below it the error is local and decays without these iterations
        constexpr double at_start = 3e-4;   // root mean square change that the first step may leave
        // Fluid that starts to bear its weight has no multiplier yet, and its iterations grow with its depth in spacings.
        const int most = starts ? 60 : 4;
        struct Sums {
            double missing = 0, squares = 0, weighted = 0;
            void operator+=(const Sums& o) { missing += o.missing, squares += o.squares, weighted += o.weighted; }
        };
        system.no_way_out &= !step.at_frame_time;
        Column<Real> more, old_p, old_pressure;
        Column<Vec3> way, push, old_solved, old_load;
        Sums first;
        double last = 0;
        for (int round = 0;; ++round) {
            parallel_for(n, [&](Index i) { work[i] = known[i] + solved[i]; });
            form.gradient(work, G.values);
            const auto missing = [&](Index i) { return role[i] == 0 ? divergence[i] - form.divergence(i, G[i]) : Real(0); };
            const Sums all = parallel_sum(n, Sums{}, [&](Index i) {
                const double m = missing(i);
                return Sums{m, m * m, static_cast<double>(form.coefficients(i).bulk * d) * m * m};
            });
            const bool kept_it = starts ? dt * std::sqrt(all.squares / n) < at_start : dt * all.missing < tolerated * n;
            if (round == 0) {
                if (kept_it || system.no_way_out ||
                    all.missing < (starts ? tolerated / 3 / dt * n : as_a_whole * std::sqrt(all.squares * n)))
                    return;
                first = all, old_solved = solved, old_load = load, old_pressure = pressure;
                old_p.assign(p.values.begin(), p.values.end());
            } else if (kept_it || round == most) {
                if (starts ? all.squares < first.squares : all.missing < first.missing / 2 && all.squares < 4 * first.squares) return;
                system.no_way_out = true;
                solved.swap(old_solved), load.swap(old_load), pressure.swap(old_pressure);
                std::copy(old_p.begin(), old_p.end(), p.values.begin());
                parallel_for(n, [&](Index i) { work[i] = known[i] + solved[i]; });
                return form.gradient(work, G.values);
            }
            const Real kept = last > 0 ? static_cast<Real>(all.weighted / last) : Real(0);
            last = all.weighted;
            more.resize(n, 0);
            way.assign(n, Vec3::Zero());
            push.assign(n, Vec3::Zero());
            parallel_for(n, [&](Index i) { more[i] = form.coefficients(i).bulk * d * missing(i) + kept * more[i]; });
            const auto along = [&] { return parallel_sum(n, [&](Index i) { return static_cast<double>(more[i]) * missing(i); }); };
            const double before = along();
            form.add_stress(more, {}, push);
            unknowns.restrict_to(push);
            if (const double size = preconditioned_norm(push); size > 0)  // push becomes the residual
                report.iterations +=
                    conjugate_gradients_from<Vec3>([this](Span<const Vec3> v, Span<Vec3> y) { return multiply(v, y); },
                                                   system.preconditioner, push, way, limits(), ResidualNorm::preconditioned, size)
                        .iterations;
            parallel_for(n, [&](Index i) { work[i] = known[i] + solved[i] + way[i]; });
            form.gradient(work, G.values);
            const double after = along();
            const Real far = before > after ? static_cast<Real>(before / (before - after)) : Real(0);
            parallel_for(n, [&](Index i) {
                solved[i] += far * way[i];
                load[i] += far * push[i];
                p[i] += far * more[i] * step.rest_density * d / (dt * system.rows.neighbourhood[i].volume);
                if (!pressure.empty()) pressure[i] += far * more[i];
            });
        }
    }

    /// If no solid or nozzle acts, all forces are internal: removes the momentum error of the unfinished solve as a rigid motion.
    void keep_momentum() {
        if (!nothing_held) return;
        parallel_for(n, [&](Index i) { work[i] = loaded(i, u[i]) - solved[i]; });
        RigidMotions(x.values, !step.domain.any_periodic()).add(work, solved);
    }

    /// Stores the new velocity, its gradient, and the new multiplier p - lambda (tr D - s). The multiplier has both signs: p < 0 holds a
    /// stretched thread together and makes it thin. The multiplier is reduced by a fraction per step. Otherwise it would grow without end
    /// in a closed vessel with too much fluid. The fraction is smaller for the part from 0 to the weight of the fluid, because fluid at
    /// rest sinks with tr D = fraction times p/lambda.
    void take_over() {
        const auto depth = [&](Index i) { return static_cast<double>(step.gravity.dot(x[i])); };
        const double infinity = std::numeric_limits<double>::infinity();
        const double weight =
            step.rest_density * (parallel_max(n, -infinity, depth) + parallel_max(n, -infinity, [&](Index i) { return -depth(i); }));
        parallel_for(n, [&](Index i) {
            const Vec3& solution = work[i];
            change[i] = solution - u[i];
            u[i] = solution;
            const Real lambda = form.coefficients(i).bulk * step.rest_density * d * d / (dt * system.rows.neighbourhood[i].volume);
            p[i] -= lambda * (form.divergence(i, G[i]) - divergence[i]);
            const Real kept = std::clamp(p[i], Real(0), static_cast<Real>(weight));
            p[i] = static_cast<Real>(options.weight_memory) * kept + static_cast<Real>(options.memory) * (p[i] - kept);
        });
    }

    /// Writes the momentum that the fluid lost to the ledgers of the solids. Walls receive the forces of the rows on their points, by
    /// strain and by pressure, and the friction of slip. The residual of the solve is distributed over all of them. A rotating vessel also
    /// receives the opposite of balance(), which replaces forces between fluid and wall.
    void write_ledgers() {
        if (!solids.any_probed()) return;
        const auto m = static_cast<double>(step.mass);
        const auto push = [&](Solid& solid, Push kind, const Vec3& at, const Vec3& velocity) {
            solid.receive(kind, Wrench::at(solid.image(at).cast<double>() - solid.centre(), m * velocity.cast<double>()));
        };
        const auto walls_take = [&](Push kind, Real sign) {
            form.each_wall_force([&](const RowBlock&, const WallPoint& wall, const Vec3& f) {
                push(solids.all[wall.solid], kind, wall.position, sign * f);
            });
        };
        if (!balancing.empty()) {
            Solid& vessel = solids.all[options.vessel];
            const Wrench on = -m * momentum_of(role, x.values, [&](Index i) { return balancing[i]; });
            vessel.receive(Push::pressure, {on.force, on.torque - vessel.centre().cross(on.force)});
        }
        const Remainder rest(solids, Push::viscous);
        form.find_wall_forces(u.values);
        walls_take(Push::viscous, -1);
        Column<Real> part(n);  // part of the pressure: first the bulk term's, then the rest
        parallel_for(n, [&](Index i) { part[i] = form.coefficients(i).bulk * d * form.divergence(i, G[i]); });
        form.find_wall_forces(part, curvature);
        walls_take(Push::viscous, 1);
        parallel_for(n, [&](Index i) { part[i] = pressure[i] - part[i]; });
        form.find_wall_forces(part, {});
        walls_take(Push::pressure, 1);
        for (const RowBlock& block : system.rows.blocks)
            for (const WallPoint& wall : block.walls) {
                const Index i = block.begin + wall.row;
                if (wall.friction > 0 && role[i] == 0)
                    push(solids.all[wall.solid], Push::viscous, wall.position,
                         ContactFriction::of(wall, mu[i], step) * (u[i] - wall.velocity));
            }
        rest.share(solids, step, m * momentum_of(role, x.values, [&](Index i) { return load[i]; }));
    }

    /// In a rotating vessel: counts the work that the pressure does on the particles that set_divergence() moves apart or together as an
    /// error. If it were counted as (negative) heat, the heat would fall.
    void count_pushes(StepReport& report) {
        if (options.vessel < 0 || !solids.any_probed()) return;
        const double pushes = parallel_sum(n, [&](Index i) {
            const Real pushed = divergence[i] - curvature[i].trace();
            return role[i] == 0 ? static_cast<double>(system.rows.neighbourhood[i].volume * p[i] * pushed) : 0.0;
        });
        if (!report.work) report.work.emplace();
        report.work->viscosity -=
            static_cast<double>(step.mass) * static_cast<double>(dt) / static_cast<double>(step.rest_density) * pushes;
    }

    /// Releases the particles that a solid with slip pulls and that are under tension, because solids only push. (Errors of the force may
    /// pull for a step in fluid under pressure. Without its wall the pressure would move the particle into the wall.)
    void release_slipping() {
        if (!system.rows.any_slip) return;
        Column<Real> pull(n, 0);
        const auto add = [&](Real sign) {
            form.each_wall_force([&](const RowBlock& block, const WallPoint& wall, const Vec3& f) {
                if (wall.slides()) pull[block.begin + wall.row] += sign * f.dot(wall.normal);
            });
        };
        form.find_wall_forces(u.values);
        add(-1);
        form.find_wall_forces(pressure, curvature);
        add(1);
        parallel_for(n, [&](Index i) {
            if (pull[i] > 0 && p[i] < 0) slip[i] = Vec3::Zero();
        });
    }
};

}  // namespace

void CoupledSolve::operator()(Read<field::position> x, Read<field::role> role, Read<field::viscosity> mu, Update<field::velocity> u,
                              Update<field::pressure> p, Update<field::velocity_change> change, Update<field::velocity_gradient> G,
                              Update<field::aggregate> aggregate, Update<field::contact_normal> slip, Solids& solids,
                              const StepContext& step, StepReport& report) const {
    if (x.size() == 0) return;
    CoupledStep now{*system, x, role, mu, u, p, change, G, aggregate, slip, solids, step};
    now.prepare();
    now.set_up_preconditioner(false);
    now.find_velocity(report);
    now.let_go();
    now.finish(report);
}

void CoupledYieldingSolve::operator()(Read<field::position> x, Read<field::role> role, Read<field::viscosity> K,
                                      Update<field::shear_rate> gamma, Write<field::apparent_viscosity> mu, Update<field::velocity> u,
                                      Update<field::pressure> p, Update<field::velocity_change> change, Update<field::velocity_gradient> G,
                                      Update<field::aggregate> aggregate, Update<field::contact_normal> slip, Solids& solids,
                                      const StepContext& step, StepReport& report) const {
    if (x.size() == 0) return;
    FlowViscosity flow(law, K, G.values, step, gamma, mu);
    system->form.limit_penalties(flow.soft);
    CoupledStep now{*system, x, role, {mu.values}, u, p, change, G, aggregate, slip, solids, step, gamma.values};
    now.prepare();
    now.looseness = law.looseness;
    for (int solves = 1;; ++solves) {
        now.set_up_preconditioner(solves > 1);
        now.find_velocity(report, solves > 1);
        now.find_shear_rates(flow.solved);
        if (!flow.again(solves)) break;
        flow.update();
        now.set_up_form();
    }
    now.looseness = 1;
    now.find_velocity(report, true);
    now.lose_energy();
    now.finish(report);
    system->form.limit_penalties({});
}

}  // namespace whorl
