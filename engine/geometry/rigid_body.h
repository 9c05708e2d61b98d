#pragma once
/// A solid that forces move: its mass and its state (docs/physics.md 7).
#include <array>
#include <iosfwd>

#include "engine/core/types.h"
#include "engine/geometry/shape.h"

namespace whorl {

/// Kinds of force between fluid and solid. `contact` includes push-out, contact in the model `coupled`, and attraction by wetting.
enum class Push { pressure, viscous, contact };
inline constexpr int pushes = 3;

/// Force and torque [N, N m], or impulse and angular impulse [N s, N m s]; torques are about a solid's centre.
struct Wrench {
    Vec3d force = Vec3d::Zero(), torque = Vec3d::Zero();
    void operator+=(const Wrench& o) { force += o.force, torque += o.torque; }
    friend Wrench operator+(Wrench a, const Wrench& b) { return a += b, a; }
    friend Wrench operator*(double s, const Wrench& w) { return {s * w.force, s * w.torque}; }
    /// The wrench of a force that acts at the distance `arm` [m] from the centre.
    static Wrench at(const Vec3d& arm, const Vec3d& force) { return {force, arm.cross(force)}; }
};

/// Impulses of the fluid on a solid during this step, by kind. In 2D per metre of depth.
struct Ledger {
    std::array<Wrench, pushes> impulse{};
    Wrench& operator[](Push kind) { return impulse[static_cast<std::size_t>(kind)]; }
    const Wrench& operator[](Push kind) const { return impulse[static_cast<std::size_t>(kind)]; }
    Wrench total() const { return impulse[0] + impulse[1] + impulse[2]; }
};

/// Rotation about the direction of the vector `angle` by the length of that vector [rad].
Eigen::AngleAxisd turn_by(const Vec3d& angle);

/// x_world = rotation x_own + translation.
struct Pose {
    Mat3 rotation = Mat3::Identity();
    Vec3 translation = Vec3::Zero();       ///< m
    Vec3 velocity = Vec3::Zero();          ///< m/s, of the origin
    Vec3 angular_velocity = Vec3::Zero();  ///< rad/s, in the world's axes
    Vec3 velocity_at(const Vec3& x) const { return velocity + angular_velocity.cross(x - translation); }
    /// Velocity, at the middle of a step of dt [s], of the point that is at x at the start of the step. If dt < 0: of the point that is
    /// at x at the end of the step.
    Vec3 velocity_over(Real dt, const Vec3& x) const { return velocity_at(x + dt / 2 * velocity_at(x)); }
};

/// Contact properties of a solid.
struct Contact {
    double friction = 0.3;  ///< Coulomb's coefficient; a pair uses the geometric mean
    double bounce = 0;      ///< coefficient of restitution; a pair uses the larger
};

/// Position, orientation, momentum and angular momentum of a body, in double precision. Every impulse that the body receives from the fluid
/// is subtracted from the fluid.
struct RigidBody {
    double mass = 0, volume = 0;            ///< kg, m^3
    Vec3d own_centre = Vec3d::Zero();       ///< centre of mass in the solid's own axes [m]
    Mat3d own_inertia = Mat3d::Identity();  ///< tensor of inertia about the centre, in the same axes [kg m^2]

    Vec3d centre = Vec3d::Zero();                              ///< m, in the world
    Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();  ///< rotation from own axes to world axes
    Vec3d velocity = Vec3d::Zero();                            ///< m/s, of the centre
    Vec3d spin_momentum = Vec3d::Zero();                       ///< angular momentum about the centre [kg m^2/s]
    Wrench pressed;  ///< force and torque of pressure and contact in the last step [N, N m]: the prediction of ExpectForce

    /// A body at rest at its shape's position. @param density kg/m^3
    RigidBody() = default;
    RigidBody(const MassProperties& bulk, double density);

    /// Inverse of the tensor of inertia in world axes [1/(kg m^2)].
    Mat3d inverse_inertia() const;
    Vec3d angular_velocity() const { return inverse_inertia() * spin_momentum; }
    void spin_at(const Vec3d& w) { spin_momentum = turn * own_inertia * turn.conjugate() * w; }
    Vec3d velocity_at(const Vec3d& x) const { return velocity + angular_velocity().cross(x - centre); }
    double kinetic_energy() const { return mass * velocity.squaredNorm() / 2 + spin_momentum.dot(angular_velocity()) / 2; }  ///< J

    void push(const Wrench& impulse) { velocity += impulse.force / mass, spin_momentum += impulse.torque; }
    /// Moves and turns freely over dt [s]. Momentum and angular momentum stay bit-identical.
    void move(double dt);
    Pose pose() const;

    void save(std::ostream& out) const;
    /// Reads a saved state; leaves `in` failed if the data end too early. @return whether the state is possible
    bool load(std::istream& in);
};

}  // namespace whorl
