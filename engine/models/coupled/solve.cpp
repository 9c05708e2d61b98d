#include <Eigen/Cholesky>

#include "engine/core/parallel.h"
#include "engine/math/conjugate_gradients.h"
#include "engine/models/coupled/system.h"

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
        const Vec3d a = x[static_cast<std::size_t>(i)].cast<double>();
        return Inertia{a, a * a.transpose()};
    });
    const Vec3d centre = inertia.first / n;
    const Mat3d second = inertia.second - n * centre * centre.transpose();
    const Mat3d theta = second.trace() * Mat3d::Identity() - second;
    const auto missing = parallel_sum(n, Momentum{}, [&](Index i) {
        const auto k = static_cast<std::size_t>(i);
        const Vec3d du = wanted[k].cast<double>() - u[k].cast<double>();
        return Momentum{du, (x[k].cast<double>() - centre).cross(du)};
    });
    const Vec3d shift = missing.linear / n;
    // A single file of particles has no inertia about its own line.
    Vec3d turn = (theta + 1e-9 * theta.trace() * Mat3d::Identity()).ldlt().solve(missing.angular);
    if (!turning) turn.setZero();
    if (!shift.allFinite() || !turn.allFinite()) return;
    parallel_for(n, [&](Index i) {
        const auto k = static_cast<std::size_t>(i);
        u[k] += (shift + turn.cross(x[k].cast<double>() - centre)).cast<Real>();
    });
}

}  // namespace

void CoupledNeighbourhood::operator()(Read<field::position> x, Read<field::role> role, Write<field::density> density,
                                      const StepContext& step) const {
    CoupledSystem& s = *system;
    s.rows.build(x.values, role.values, step.domain, step.spacing, s.options);
    parallel_for(x.size(),
                 [&](Index i) { density[i] = step.rest_density * s.rows.neighbourhood[static_cast<std::size_t>(i)].density; });
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
    form.set(s.rows, mu.values, dt, step.rest_density, d, o);

    Unknowns unknowns{role.values, slip.values};
    Index free_particles = 0;
    for (Index i = 0; i < n; ++i) {
        free_particles += role[i] == 0;
        unknowns.any_slip |= slip[i] != Vec3::Zero();
    }
    const bool nothing_held = free_particles == n && !unknowns.any_slip;

    // What is known: velocities of nozzles and solids. A particle that slides knows its velocity along the normal.
    std::vector<Vec3> known(count, Vec3::Zero()), b(count), start(count);
    parallel_for(n, [&](Index i) {
        const auto k = static_cast<std::size_t>(i);
        if (role[i] > 0) u[i] = solids.all[static_cast<std::size_t>(role[i] - 1)].pose.velocity_at(x[i]);
        if (role[i] != 0) known[k] = u[i];
        else if (unknowns.any_slip && slip[i] != Vec3::Zero()) {
            Real distance = 0;
            const int solid = solids.nearest(x[i], distance);
            if (solid >= 0) known[k] = slip[i] * slip[i].dot(solids.all[static_cast<std::size_t>(solid)].pose.velocity_at(x[i]));
        }
    });

    // s_i: compressed particles part; and a body that turns needs div u = -dt I2(grad u) to keep its volume under x += dt u.
    // q_i: the multiplier, and the bulk term's part that does not depend on u.
    std::vector<Real> target(count), q(count);
    const double fastest = std::sqrt(parallel_max(n, 0, [&](Index i) { return static_cast<double>(u[i].squaredNorm()); }));
    const double turning_limit = o.turning_limit * fastest / d;
    const double fastest_push = o.fastest_push * (fastest / d + std::sqrt(step.gravity.norm() / d));
    parallel_for(n, [&](Index i) {
        const auto k = static_cast<std::size_t>(i);
        const double compressed = s.rows.neighbourhood[k].density - 1;
        double wanted = compressed > 0 ? std::min(o.push * compressed / dt, fastest_push) : 0;
        if (role[i] == 0) wanted += std::clamp(-double(dt) * second_invariant(G[i]), -turning_limit, turning_limit);
        target[k] = static_cast<Real>(wanted);
        q[k] = form.coefficients(i).bulk * d * target[k] + dt * p[i] / (step.rest_density * d);
    });
    if (const std::vector<Real>& P = *s.known_pressure; P.size() == count)
        parallel_for(n, [&](Index i) { q[static_cast<std::size_t>(i)] += dt * P[static_cast<std::size_t>(i)] / (step.rest_density * d); });
    parallel_for(n, [&](Index i) { b[static_cast<std::size_t>(i)] = u[i] + dt * step.gravity; });
    const std::vector<Vec3> pushed = nothing_held ? b : std::vector<Vec3>{};
    form.add_pressure(q, b);

    const bool coarse = free_particles >= o.fewest_for_coarse;
    if (!coarse) s.preconditioner.clear();
    else if (step.at_landing || s.preconditioner.unknowns() == 0 || s.steps_since_refresh >= o.refresh_every) {
        s.preconditioner.refresh(form, x.values, role.values, o, step.domain, d, aggregate.values);
        s.steps_since_refresh = 0;
    }
    ++s.steps_since_refresh;
    s.preconditioner.set(form, x.values, role.values, slip.values, step.domain, d, aggregate.values);

    // The residual is measured against the loads on the fluid, not against the large forces by which nozzle and solids hold their neighbours;
    // these count a little, for a fluid at rest that is only dragged along.
    const auto load_norm = [&](Span<const Vec3> load) {
        s.preconditioner(load, start);
        return std::sqrt(std::max(0.0, dot<Vec3>(load, start)));
    };
    unknowns.restrict_to(b);
    double reference = load_norm(b);
    if (!nothing_held) {
        form.apply(known, start);
        parallel_for(n, [&](Index i) {
            const auto k = static_cast<std::size_t>(i);
            b[k] -= unknowns.part(k, start[k]);
        });
        reference = std::max(reference, 0.03 * load_norm(b));
    }

    parallel_for(n, [&](Index i) {
        const auto k = static_cast<std::size_t>(i);
        start[k] = unknowns.part(k, u[i] + Real(0.9) * change[i]);
    });
    const auto A = [&](Span<const Vec3> v, Span<Vec3> y) {
        form.apply(v, y);
        unknowns.restrict_to(y);
    };
    SolveReport solved =
        conjugate_gradients<Vec3>(A, s.preconditioner, b, start, o.limits, ResidualNorm::preconditioned, reference);
    report.solves.push_back({"coupled", solved});
    if (nothing_held) restore_momentum(x.values, pushed, !step.domain.any_periodic(), start);

    parallel_for(n, [&](Index i) {
        const auto k = static_cast<std::size_t>(i);
        const Vec3 solution = known[k] + start[k];
        change[i] = solution - u[i];
        u[i] = solution;
    });
    form.gradient(u.values, G.values);

    // p <- memory (p - lambda (tr D - s)): of both signs; what holds a stretched thread together and makes it thin is p < 0.
    const Real memory = static_cast<Real>(o.memory);
    parallel_for(n, [&](Index i) {
        const Real lambda = form.coefficients(i).bulk * step.rest_density * d * d / dt;
        p[i] = memory * (p[i] - lambda * (form.divergence(i, G[i]) - target[static_cast<std::size_t>(i)]));
    });

    if (unknowns.any_slip) {
        // A solid that slips can push, not pull: where it would have to pull, it lets go.
        std::vector<Vec3> balance(count);
        form.apply(u.values, balance);
        std::vector<Vec3> load(count);
        parallel_for(n, [&](Index i) { load[static_cast<std::size_t>(i)] = u[i] - change[i] + dt * step.gravity; });
        form.add_pressure(q, load);
        parallel_for(n, [&](Index i) {
            const auto k = static_cast<std::size_t>(i);
            if (slip[i].dot(balance[k] - load[k]) < 0) slip[i] = Vec3::Zero();
        });
    }
}

}  // namespace whorl
