#include "engine/geometry/rigid_body.h"

#include <Eigen/LU>
#include <cmath>
#include <istream>
#include <ostream>

namespace whorl {

Eigen::AngleAxisd turn_by(const Vec3d& angle) {
    const double size = angle.norm();
    return size > 0 ? Eigen::AngleAxisd(size, angle / size) : Eigen::AngleAxisd::Identity();
}

RigidBody::RigidBody(const MassProperties& bulk, double density)
    : mass(density * bulk.volume), volume(bulk.volume), own_centre(bulk.centre), own_inertia(density * bulk.inertia()),
      centre(bulk.centre) {}

Mat3d RigidBody::inverse_inertia() const {
    const Mat3d R = turn.toRotationMatrix();
    return R * own_inertia.inverse() * R.transpose();
}

// dq/dt = w(q) q/2 with w = I(q)^-1 L and constant L, by the midpoint rule, solved by fixed-point iteration. L is constant in space, so
// angular momentum is conserved exactly.
void RigidBody::move(double dt) {
    centre += dt * velocity;
    const Eigen::Quaterniond start = turn;
    Vec3d w = angular_velocity();
    for (int k = 0; k < 4; ++k) {
        turn = Eigen::Quaterniond(turn_by(dt / 2 * w)) * start;
        w = angular_velocity();
    }
    turn = (Eigen::Quaterniond(turn_by(dt * w)) * start).normalized();
}

Pose RigidBody::pose() const {
    const Mat3d R = turn.toRotationMatrix();
    const Vec3d origin = centre - R * own_centre;
    Pose pose;
    pose.rotation = R.cast<Real>();
    pose.translation = origin.cast<Real>();
    pose.velocity = velocity_at(origin).cast<Real>();
    pose.angular_velocity = angular_velocity().cast<Real>();
    return pose;
}

void RigidBody::save(std::ostream& out) const {
    for (const double* values : {centre.data(), velocity.data(), spin_momentum.data(), pressed.force.data(), pressed.torque.data()})
        out.write(reinterpret_cast<const char*>(values), 3 * sizeof(double));
    out.write(reinterpret_cast<const char*>(turn.coeffs().data()), 4 * sizeof(double));
}

bool RigidBody::load(std::istream& in) {
    for (double* values : {centre.data(), velocity.data(), spin_momentum.data(), pressed.force.data(), pressed.torque.data()})
        in.read(reinterpret_cast<char*>(values), 3 * sizeof(double));
    in.read(reinterpret_cast<char*>(turn.coeffs().data()), 4 * sizeof(double));
    return centre.allFinite() && velocity.allFinite() && spin_momentum.allFinite() && pressed.force.allFinite() &&
           pressed.torque.allFinite() && std::abs(turn.norm() - 1) < 1e-3;
}

}  // namespace whorl
