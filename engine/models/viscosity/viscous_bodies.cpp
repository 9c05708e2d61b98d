#include "engine/models/viscosity/viscous_bodies.h"

namespace whorl {

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
