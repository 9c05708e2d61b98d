// Solids in the viscous operator. Free bodies: the effect of their unknowns on the particles' sums, and the transpose of this effect
// (viscous_bodies.h). Other solids: ledger entries.
#include <Eigen/LU>

#include "engine/models/bodies/reaction.h"
#include "engine/models/viscosity/sticking_walls.h"

namespace whorl {
namespace {

Mat3 crossing(const Vec3& a) {
    Mat3 X;
    X << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
    return X;
}

/// sum over columns k of e_k x (M e_k), with M = Q N: the torque sum w r x Q r for N = sum w r r^T.
Vec3 turning_part(const Mat3& M) { return {M(2, 1) - M(1, 2), M(0, 2) - M(2, 0), M(1, 0) - M(0, 1)}; }

}  // namespace

void ViscousOperator::set_up_bodies(const ViscosityOptions& options, const InteractionContext& context) {
    bodies_ = {};
    if (context.boundary.size() == 0 || !context.solids.any_free()) return;
    with_kernel(context.step.kernel, context.step.support, [&](const auto& kernel) {
        const StickingWalls walls(kernel, context, options);
        bodies_.set_up(context.solids, context.step.mass, size(), particles_at_bodies(context), [&](Index i, std::size_t k) {
            BodyTouch touch;
            const Real factor = walls.factor(i);
            context.solid_pairs.of(i, [&](Index s, const Vec3& r, Real distance) {
                if (static_cast<std::size_t>(context.boundary.solid[s]) != k) return;
                const Real w = walls.weight(factor, s, distance), stretch = walls.stretch(s, r);
                touch.arm = context.boundary.position[s] + r - context.solids.all[k].body->centre.cast<Real>();
                touch.g += stretch * w * r;
                touch.N += w * r * r.transpose();
                touch.h += stretch * stretch * w;
            });
            return touch;
        });
    });
}

// A_i -= sum_s w V_s r^T,   own_i -= 2 c_i sum_s stretch w V_s
void ViscousOperator::subtract_body_velocities(Index i, Span<const Vec3> u, Mat3& A, Vec3& own) const {
    for (std::size_t e = bodies_.first[i]; e < bodies_.first[i + 1]; ++e) {
        const BodyTouch& t = bodies_.touch[e];
        const Vec3 &v = u[K_.size() + (2 * t.body)], &w = u[K_.size() + (2 * t.body + 1)];
        const Vec3 U = t.at(v, w);
        A -= U * t.g.transpose() - crossing(w) * t.N;
        own -= 2 * c_[i] * (t.h * U - w.cross(t.g));
    }
}

// F_s = w Q r + 2 c w (stretch u_i - V_s):   force = sum stretch F_s,   torque = a x force - sum r x F_s
void ViscousOperator::set_body_forces(Index i, Span<const Vec3> u, const Vec3& own_velocity, const Mat3& Q) const {
    for (std::size_t e = bodies_.first[i]; e < bodies_.first[i + 1]; ++e) {
        BodyTouch& t = bodies_.touch[e];
        const Vec3 &v = u[K_.size() + (2 * t.body)], &w = u[K_.size() + (2 * t.body + 1)];
        const Vec3 apart = own_velocity - t.at(v, w);
        const Real c = 2 * c_[i];
        t.force = Q * t.g + c * (t.h * apart + w.cross(t.g));
        t.torque = t.arm.cross(t.force) - (turning_part(Q * t.N) + c * (t.g.cross(apart) + t.N.trace() * w - t.N * w));
    }
}

// F_s as above, for solids with a known velocity: stretch F_s acts at x_i - r/stretch.
void ViscousOperator::write_ledgers(const ImplicitStep& step, Span<const Vec3> u) const {
    const InteractionContext& context = step.context;
    if (context.boundary.size() == 0) return;
    with_kernel(context.step.kernel, context.step.support, [&](const auto& kernel) {
        const StickingWalls walls(kernel, context, options_);
        react(
            context, Push::viscous, step.role, context.step.mass,
            [&](Index i) {
                return [&, i, factor = walls.factor(i), Q = Q_[i].matrix()](Index s, const Vec3& r, Real distance) {
                    const Real w = walls.weight(factor, s, distance), stretch = walls.stretch(s, r);
                    return PushAt(-stretch * w * (Q * r + 2 * c_[i] * (stretch * u[i] - walls.velocity(s, r, stretch))), r / stretch);
                };
            },
            Writes::driven);
    });
    friction_.write_ledgers(context, step.role, u, [&](Index i) { return dt_nu_[i] / context.step.dt; });
}

void ViscousOperator::sum_bodies(Span<const Vec3> u, Span<Vec3> y) const {
    const std::size_t n = K_.size();
    bodies_.weigh(u.subspan(n), y.subspan(n));
    for (std::size_t b = 0; b < bodies_.body.size(); ++b) {
        Vec3d force = Vec3d::Zero(), torque = Vec3d::Zero();
        for (const std::size_t e : bodies_.body[b].touches)
            force += bodies_.touch[e].force.cast<double>(), torque += bodies_.touch[e].torque.cast<double>();
        y[n + 2 * b] -= force.cast<Real>();
        y[n + 2 * b + 1] -= torque.cast<Real>();
    }
}

/// Analogue of set_up_blocks() for bodies. The block of a rotation is the energy of its velocities at the particles.
void ViscousOperator::set_up_body_blocks() {
    body_blocks_.assign(2 * bodies_.body.size(), Mat3d::Zero());
    for (std::size_t b = 0; b < bodies_.body.size(); ++b) {
        Mat3d moving = bodies_.body[b].mass * Mat3d::Identity(), turning = bodies_.body[b].turning;
        for (const std::size_t e : bodies_.body[b].touches) {
            const BodyTouch& t = bodies_.touch[e];
            const auto i = static_cast<std::size_t>(t.particle);
            const Vec3 h = M_[i].matrix() * t.g;
            Mat3 S = h * h.transpose();
            S.diagonal().array() += h.squaredNorm();
            Mat3 B = K_[i] * P_[i].matrix() * S * P_[i].matrix();
            B.diagonal().array() += 2 * c_[i] * std::max(Real(0), t.h - h.dot(t.g));
            const Mat3d X = crossing(t.arm).cast<double>(), Bd = B.cast<double>();
            moving += Bd;
            turning += X.transpose() * Bd * X;
        }
        body_blocks_[2 * b] = moving.inverse();
        body_blocks_[2 * b + 1] = turning.inverse();
    }
}

void ViscousOperator::divide_by_diagonal(Span<const Vec3> r, Span<Vec3> z) const {
    diagonal_.apply(r, z);
    for (std::size_t k = 0; k < body_blocks_.size() && bodies(); ++k)
        z[K_.size() + k] = (body_blocks_[k] * r[K_.size() + k].cast<double>()).cast<Real>();
}

void ViscousBodies::read(const Solids& solids, Span<Vec3> entries) const {
    for (std::size_t b = 0; b < body.size(); ++b) {
        const RigidBody& state = *solids.all[body[b].solid].body;
        entries[2 * b] = state.velocity.cast<Real>();
        entries[2 * b + 1] = state.angular_velocity().cast<Real>();
    }
}

void ViscousBodies::add_change(Span<const Vec3> change, Solids& solids) const {
    for (std::size_t b = 0; b < body.size(); ++b) {
        Solid& solid = solids.all[body[b].solid];
        const Mat3d R = solid.body->turn.toRotationMatrix(), inertia = R * solid.body->own_inertia * R.transpose();
        solid.receive(Push::viscous, {solid.body->mass * change[2 * b].cast<double>(), inertia * change[2 * b + 1].cast<double>()});
    }
}

Wrench ViscousBodies::residual(Span<const Vec3> y, Span<const Vec3> u, Span<const Vec3> change) const {
    Wrench sum;
    for (std::size_t b = 0; b < body.size(); ++b) {
        const auto less = [&](std::size_t k, const auto& inertia) {
            return Vec3d(y[k].cast<double>() - inertia * (u[k] - change[k]).cast<double>());
        };
        const Vec3d force = less(2 * b, body[b].mass);
        sum += Wrench{force, less(2 * b + 1, body[b].turning) + body[b].centre.cross(force)};
    }
    return sum;
}

void ViscousBodies::weigh(Span<const Vec3> u, Span<Vec3> y) const {
    for (std::size_t b = 0; b < body.size(); ++b) {
        y[2 * b] = (body[b].mass * u[2 * b].cast<double>()).cast<Real>();
        y[2 * b + 1] = (body[b].turning * u[2 * b + 1].cast<double>()).cast<Real>();
    }
}

}  // namespace whorl
