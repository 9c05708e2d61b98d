// Forces of the fluid on solids, after the coupled solve.
#include "engine/core/parallel.h"
#include "engine/models/bodies/reaction.h"
#include "engine/models/viscosity/coupled/coupled_step.h"

namespace whorl {

/// Writes the momentum that the fluid lost to the ledgers of the solids. Walls receive the forces of the rows on their points, by
/// strain and by pressure, and the friction of slip. The residual of the solve is distributed over all of them. A rotating vessel also
/// receives the opposite of balance(), which replaces forces between fluid and wall.
void CoupledStep::write_ledgers() {
    if (!writes_ledgers()) return;
    const auto m = static_cast<double>(step.mass);
    const auto push = [&](Solid& solid, Push kind, const Vec3& at, const Vec3& velocity) {
        const Wrench impulse = Wrench::at(solid.image(at).cast<double>() - solid.centre(), m * velocity.cast<double>());
        if (solid.body) solid.ledger[kind] += impulse;  // the solve has moved the body
        else solid.receive(kind, impulse);
    };
    const auto walls_take = [&](Push kind, Real sign) {
        form.each_wall_force(
            [&](const RowBlock&, const WallPoint& wall, const Vec3& f) { push(solids.all[wall.solid], kind, wall.position, sign * f); });
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
                push(solids.all[wall.solid], Push::viscous, wall.position, ContactFriction::of(wall, mu[i], step) * (u[i] - wall.velocity));
        }
    rest.share(solids, step, m * momentum_of(role, x.values, [&](Index i) { return load[i]; }));
}

/// In a rotating vessel: counts the work that the pressure does on the particles that set_divergence() moves apart or together as an
/// error. If it were counted as (negative) heat, the heat would fall.
void CoupledStep::count_pushes(StepReport& report) {
    if (options.vessel < 0 || !solids.any_probed()) return;
    const double power = parallel_sum(n, [&](Index i) {
        const Real pushed = divergence[i] - curvature[i].trace();
        return role[i] == 0 ? static_cast<double>(system.rows.neighbourhood[i].volume * p[i] * pushed) : 0.0;
    });
    if (!report.work) report.work.emplace();
    report.work->viscosity -= static_cast<double>(step.mass) * static_cast<double>(dt) / static_cast<double>(step.rest_density) * power;
}

/// Releases the particles that a solid with slip pulls and that are under tension, because solids only push. (Errors of the force may
/// pull for a step in fluid under pressure. Without its wall the pressure would move the particle into the wall.)
void CoupledStep::release_slipping() {
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

}  // namespace whorl
