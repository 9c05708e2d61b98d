#include <Eigen/Cholesky>

#include "engine/core/parallel.h"
#include "engine/math/conjugate_gradients.h"
#include "engine/models/coupled/system.h"
#include "engine/particles/largest_speed.h"

namespace whorl {
namespace {

/// (tr(G)^2 - tr(G^2)) / 2: what det(1 + dt G) adds to 1 + dt tr G at second order.
Real second_invariant(const Mat3& G) {
    const Real t = G.trace();
    return Real(0.5) * (t * t - (G * G).trace());
}

/// Leaves of v what is not prescribed: nothing of a particle stuck or in a nozzle, the tangential part of one that slides.
struct Unknowns {
    Span<const std::int16_t> role;
    Span<const Vec3> slip;
    bool any_slip = false;

    Vec3 part(std::size_t i, const Vec3& v) const {
        if (role[i] != 0) return Vec3::Zero();
        return any_slip ? Vec3(v - slip[i] * slip[i].dot(v)) : v;
    }
    void restrict_to(Span<Vec3> v) const {
        parallel_for(static_cast<Index>(v.size()), [&](Index i) {
            const auto k = static_cast<std::size_t>(i);
            v[k] = part(k, v[k]);
        });
    }
};

/// Where the last step's change is a bad guide (a jolt, a landing): goes along it to where the energy is least.
/// @param r the residual of u, kept up to date
template <class Operator>
void look_along_change(const Operator& A, const Unknowns& unknowns, Span<const Vec3> change, Span<Vec3> r, Span<Vec3> u) {
    std::vector<Vec3> way(change.begin(), change.end()), bent(change.size());
    unknowns.restrict_to(way);
    A(way, bent);
    const double stiffness = dot<Vec3>(way, bent);
    if (!(stiffness > 0) || !std::isfinite(stiffness)) return;
    const Real far = static_cast<Real>(dot<Vec3>(way, r) / stiffness);
    parallel_for(static_cast<Index>(u.size()), [&](Index i) {
        u[i] += far * way[i];
        r[i] -= far * bent[i];
    });
}

struct Momentum {
    Vec3d linear = Vec3d::Zero(), angular = Vec3d::Zero();
    Momentum& operator+=(const Momentum& o) {
        linear += o.linear, angular += o.angular;
        return *this;
    }
};
struct Inertia {
    Vec3d first = Vec3d::Zero();
    Mat3d second = Mat3d::Zero();
    Inertia& operator+=(const Inertia& o) {
        first += o.first, second += o.second;
        return *this;
    }
};

/// Where nothing holds the fluid, its forces are all internal: a rigid motion takes out what the unfinished solve did to the momentum.
/// @param turning also the angular momentum (it has no meaning along a periodic axis)
void restore_momentum(Span<const Vec3> x, Span<const Vec3> wanted, bool turning, Span<Vec3> u) {
    const auto n = static_cast<Index>(x.size());
    const auto inertia = parallel_sum(n, Inertia{}, [&](Index i) {
        const Vec3d a = x[i].cast<double>();
        return Inertia{a, a * a.transpose()};
    });
    const Vec3d centre = inertia.first / n;
    const Mat3d second = inertia.second - n * centre * centre.transpose();
    const Mat3d theta = second.trace() * Mat3d::Identity() - second;
    const auto missing = parallel_sum(n, Momentum{}, [&](Index i) {
        const Vec3d du = wanted[i].cast<double>() - u[i].cast<double>();
        return Momentum{du, (x[i].cast<double>() - centre).cross(du)};
    });
    const Vec3d shift = missing.linear / n;
    // A single file of particles has no inertia about its own line.
    Vec3d turn = (theta + 1e-9 * theta.trace() * Mat3d::Identity()).ldlt().solve(missing.angular);
    if (!turning) turn.setZero();
    if (!shift.allFinite() || !turn.allFinite()) return;
    parallel_for(n, [&](Index i) { u[i] += (shift + turn.cross(x[i].cast<double>() - centre)).cast<Real>(); });
}

}  // namespace

void CoupledNeighbourhood::operator()(Read<field::position> x, Read<field::role> role, Write<field::density> density,
                                      const StepContext& step) const {
    CoupledSystem& s = *system;
    s.rows.build(x.values, role.values, step.domain, step.spacing, s.options);
    parallel_for(x.size(), [&](Index i) { density[i] = step.rest_density * s.rows.neighbourhood[i].density; });
}

void CoupledSolve::operator()(Read<field::position> x, Read<field::role> role, Read<field::viscosity> mu, Update<field::velocity> u,
                              Update<field::pressure> p, Update<field::velocity_change> change, Update<field::velocity_gradient> G,
                              Update<field::aggregate> aggregate, Update<field::contact_normal> slip, const Solids& solids,
                              const StepContext& step, StepReport& report) const {
    CoupledSystem& s = *system;
    const CoupledOptions& o = s.options;
    const Index n = x.size();
    const auto count = static_cast<std::size_t>(n);
    const Real dt = step.dt, d = step.spacing;
    if (n == 0) return;
    StrainForm& form = s.form;
    s.friction.set(x.values, role.values, mu.values, solids, step);
    form.set(s.rows, mu.values, s.friction.counted, dt, step.rest_density, d, o);
    form.set_friction(s.friction.hold);

    Unknowns unknowns{role.values, slip.values};
    Index free_particles = 0;
    for (Index i = 0; i < n; ++i) {
        free_particles += role[i] == 0;
        unknowns.any_slip |= slip[i] != Vec3::Zero();
    }
    const bool nothing_held = free_particles == n && !unknowns.any_slip && !s.friction.acts();

    // What is known: velocities of nozzles and solids. A particle that slides knows its velocity along the normal.
    std::vector<Vec3> known(count, Vec3::Zero()), b(count), start(count);
    parallel_for(n, [&](Index i) {
        if (role[i] > 0) u[i] = solids.all[role[i] - 1].pose.velocity_at(x[i]);
        if (role[i] != 0) known[i] = u[i];
        else if (unknowns.any_slip && slip[i] != Vec3::Zero()) {
            Real distance = 0;
            const int solid = solids.nearest(x[i], distance);
            if (solid >= 0) known[i] = slip[i] * slip[i].dot(solids.all[solid].pose.velocity_at(x[i]));
        }
    });

    // s_i: compressed particles part; and a body that turns needs div u = -dt I2(grad u) to keep its volume under x += dt u.
    // q_i: the multiplier, and the bulk term's part that does not depend on u.
    std::vector<Real> target(count), q(count);
    const std::vector<Real>& known_pressure = *s.known_pressure;
    const bool any_known = known_pressure.size() == count;
    const auto set_pressure = [&](Index i) {
        q[i] = form.coefficients(i).bulk * d * target[i] + dt * (p[i] + (any_known ? known_pressure[i] : 0)) / (step.rest_density * d);
    };
    const double fastest = largest_speed(u.values);
    const double turning_limit = o.turning_limit * fastest / d;
    const double fastest_push = o.fastest_push * (fastest / d + std::sqrt(step.gravity.norm() / d));
    parallel_for(n, [&](Index i) {
        const Neighbourhood& hood = s.rows.neighbourhood[i];
        // Only apart: drawing together what is stretched would be a creep that never ends.
        const double compressed = hood.density - 1;
        double wanted = compressed > 0 ? std::min(o.push * compressed / dt, fastest_push) : 0;
        if (role[i] == 0) wanted += std::clamp(-double(dt) * second_invariant(G[i]), -turning_limit, turning_limit);
        target[i] = static_cast<Real>(wanted);
        set_pressure(i);
    });
    const auto loaded = [&](Index i, const Vec3& before) -> Vec3 {
        const Vec3 load = before + dt * step.gravity;
        return s.friction.acts() ? Vec3(load + s.friction.pull[i]) : load;
    };
    const auto set_load = [&] {
        parallel_for(n, [&](Index i) { b[i] = loaded(i, u[i]); });
        form.add_pressure(q, b);
        unknowns.restrict_to(b);
    };

    const bool coarse = o.diagonal && free_particles >= o.fewest_for_coarse;
    if (!coarse) s.preconditioner.clear();
    else if (step.at_landing || s.preconditioner.unknowns() == 0 || s.steps_since_refresh >= o.refresh_every) {
        s.preconditioner.refresh(form, x.values, role.values, o, step.domain, d, aggregate.values);
        s.steps_since_refresh = 0;
    }
    ++s.steps_since_refresh;

    // The residual is measured against the loads on the fluid, not against the large forces by which nozzle and solids hold their
    // neighbours; these count a little, for a fluid at rest that is only dragged along.
    std::vector<Vec3> z(count);
    const auto load_norm = [&](Span<const Vec3> load) {
        s.preconditioner(load, z);
        return std::sqrt(std::max(0.0, dot<Vec3>(load, z)));
    };
    const auto A = [&](Span<const Vec3> v, Span<Vec3> y) {
        form.apply(v, y);
        unknowns.restrict_to(y);
    };
    parallel_for(n, [&](Index i) {
        const auto k = static_cast<std::size_t>(i);
        start[k] = unknowns.part(k, u[i] + Real(0.9) * change[i]);
    });
    // p - lambda (tr D - s): what the multiplier becomes.
    const auto multiplier = [&](Index i) {
        const Real lambda = form.coefficients(i).bulk * step.rest_density * d * d / dt;
        return p[i] - lambda * (form.divergence(i, G[i]) - target[i]);
    };
    const auto solve_from = [&](Span<Vec3> load, Span<Vec3> guess, double reference) {
        if (!(reference > 0)) return conjugate_gradients<Vec3>(A, s.preconditioner, load, guess, o.limits, ResidualNorm::preconditioned);
        A(guess, z);
        parallel_for(n, [&](Index i) { load[i] -= z[i]; });  // the residual
        if (load_norm(load) > reference) look_along_change(A, unknowns, change.values, load, guess);
        return conjugate_gradients_from<Vec3>(A, s.preconditioner, load, guess, o.limits, ResidualNorm::preconditioned, reference);
    };
    s.preconditioner.set(form, x.values, role.values, slip.values, step.domain, d, aggregate.values);
    if (!o.diagonal) s.preconditioner.let_through();
    set_load();
    double reference = load_norm(b);
    if (!nothing_held) {
        form.apply(known, z);
        parallel_for(n, [&](Index i) {
            const auto k = static_cast<std::size_t>(i);
            b[k] -= unknowns.part(k, z[k]);
        });
        reference = std::max(reference, 0.03 * load_norm(b));
    }
    const SolveReport solved = solve_from(b, start, reference);
    if (nothing_held) {
        parallel_for(n, [&](Index i) { z[i] = loaded(i, u[i]); });
        restore_momentum(x.values, z, !step.domain.any_periodic(), start);
    }
    parallel_for(n, [&](Index i) { z[i] = known[i] + start[i]; });
    form.gradient(z, G.values);
    report.solves.push_back({"coupled", solved});
    parallel_for(n, [&](Index i) {
        const Vec3& solution = z[i];
        change[i] = solution - u[i];
        u[i] = solution;
    });

    // Of both signs: what holds a stretched thread together and makes it thin is p < 0.
    parallel_for(n, [&](Index i) { p[i] = static_cast<Real>(o.memory) * multiplier(i); });

    if (unknowns.any_slip) {
        // A solid that slips can push, not pull: where it would have to pull, it lets go.
        std::vector<Vec3> balance(count);
        form.apply(u.values, balance);
        std::vector<Vec3> load(count);
        parallel_for(n, [&](Index i) { load[i] = loaded(i, u[i] - change[i]); });
        form.add_pressure(q, load);
        parallel_for(n, [&](Index i) {
            if (slip[i].dot(balance[i] - load[i]) < 0) slip[i] = Vec3::Zero();
        });
    }
}

}  // namespace whorl
