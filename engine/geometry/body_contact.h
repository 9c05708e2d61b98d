#pragma once
/// Free bodies touch each other and the other solids (docs/physics.md 7).
#include <Eigen/SparseCore>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "engine/geometry/domain.h"
#include "engine/geometry/solids.h"

namespace whorl {

/// Parameters of a time step for contact.
struct ContactStep {
    double dt = 0;       ///< s
    double spacing = 0;  ///< m, between the particles of the layers
    double gravity = 0;  ///< m/s^2, its size
    Domain domain;
    double clearance = 0;  ///< m: bodies come no nearer than this to other solids; those that are nearer may stay
};

/// Velocity of the centre and angular velocity of each free body, one after the other [m/s, rad/s]; or force and torque about the centre.
using BodyVector = Eigen::VectorXd;
BodyVector velocities_of(const Solids& solids);

/// Contact as a law for the bodies' velocities, to be held by whatever solve moves them. At each place of contact
///   v_n >= -gap/dt,   impulse_n >= 0,   one of them an equality,   |impulse_t| <= friction impulse_n, opposite to v_t where equal
/// with v_n and v_t the parts of the relative velocity there. A place of contact is looked for from each particle of a body's layer near
/// the other solid: down along the body's surface to where it is deepest. Impulses are equal and opposite, so momentum and angular momentum
/// stay. They are found one after the other in a fixed order, over and over (projected Gauss-Seidel). Overlaps are pushed apart by a fifth
/// a step, or in 0.1 sqrt(d/g) where that is longer. A body bounces where it comes faster than free fall over a spacing.
/// The places of a flat face are those that bound it. Friction acts nearer its middle, such that it brakes a spin about the normal as if
/// the load were spread evenly over the face.
class BodyContacts {
public:
    /// Finds the places of contact of a step that begins with the bodies' velocities as they are.
    void find(const Solids& solids, const BoundaryParticles& boundary, const ContactStep& step);
    bool empty() const { return points_.empty(); }
    /// Velocities after contact. @param free velocities that the bodies would have without contact
    BodyVector velocities(const BodyVector& free);
    /// From now on change() holds the contacts that pressed in the last velocities(), and sticks where they stuck.
    void hold();
    /// M^-1 f - M^-1 J^T (J M^-1 J^T)^-1 J M^-1 f: how f changes velocities() [m/s, rad/s]. J v are the velocities at the held contacts, M
    /// masses and tensors of inertia. Symmetric, positive semi-definite.
    /// @param impulses N s, N m s
    BodyVector change(const BodyVector& impulses) const;
    BodyVector free_change(const BodyVector& impulses) const { return lightness_ * impulses; }
    /// Gives the bodies the velocities that contact makes of theirs, which may hold the impulses of an earlier call.
    void resolve(Solids& solids);

private:
    /// A direction in which an impulse acts on a and its opposite on b.
    struct Direction {
        Vec3d along;                         ///< unit vector
        Vec3d arm_a, arm_b = Vec3d::Zero();  ///< torque about the centre for an impulse of 1 [m]; arm_b: if b is free
        Vec3d turn_a, turn_b;                ///< change of angular velocity for an impulse of 1 [1/(kg m)]
        double softness = 0;                 ///< change of the relative velocity for an impulse of 1 [1/kg]
        double impulse = 0, given = 0;       ///< on a [kg m/s]; that the body has from resolve()
    };
    /// A place on the surface of body `a` at the surface of solid `b`.
    struct Point {
        std::size_t a, b;
        std::array<Direction, 3> ways;       ///< normal from b to a; two across it, for friction
        double crossed = 0;                  ///< change of the velocity along one of the latter for an impulse along the other [1/kg]
        Vec3d place;                         ///< m
        Vec3d arm_a, arm_b = Vec3d::Zero();  ///< from the centres [m]; arm_b: if b is free
        Vec3d grip = Vec3d::Zero();          ///< from the place to where friction acts [m]
        Vec3d wall = Vec3d::Zero();          ///< velocity of b if it is not free [m/s]
        double gap = 0;                      ///< m
        double wanted = 0;                   ///< m/s, the least v_n
        double friction = 0;
        bool slides() const { return std::hypot(ways[1].impulse, ways[2].impulse) >= (1 - 1e-6) * friction * ways[0].impulse; }
    };
    /// A body while impulses act on it; other solids do not move.
    struct Moving {
        Vec3d velocity = Vec3d::Zero(), turning = Vec3d::Zero();  ///< m/s, rad/s
        double lightness = 0;                                     ///< 1/kg
        Mat3d inverse_inertia = Mat3d::Zero();
        Eigen::Index slot = -1;  ///< position in a BodyVector
    };

    void look_from(const Solids& solids, const BoundaryParticles& boundary, std::size_t a, std::size_t b, Index s, const Vec3d& image);
    /// Reduces the points from `first` on, of one pair of solids, to those that bound each face, and the deepest: a face is
    /// flat, so the others hold where these do.
    void thin(std::size_t first);
    Vec3d deepest(const Solid& a, const Solid& b, const Vec3d& image, const Vec3d& start) const;
    void want(const Solids& solids);
    Direction direction(const Point& p, const Vec3d& along, const Vec3d& from_place) const;
    double speed(const Point& p, const Direction& n) const;
    void push(const Point& p, Direction& n, double impulse);
    double push_apart(Point& p);
    double hold_back(Point& p);
    /// Adds the independent ones of the velocities that points first to last, of one pair of solids, hold at rest to J.
    void add_rows(std::size_t first, std::size_t last, std::vector<Eigen::Triplet<double>>& J) const;

    ContactStep step_;
    std::vector<Moving> moving_;  ///< by solid
    Eigen::Index slots_ = 0;
    std::vector<Point> points_;              ///< in the order of the pairs of solids
    Eigen::SparseMatrix<double> lightness_;  ///< M^-1
    struct Held;
    std::shared_ptr<const Held> held_;  ///< null: nothing is held
};

}  // namespace whorl
