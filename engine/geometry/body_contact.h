#pragma once
/// Contact of free bodies with each other and with other solids (docs/physics.md 7).
#include <Eigen/SparseCore>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "engine/geometry/domain.h"
#include "engine/geometry/solids.h"

namespace whorl {

/// Parameters of contact for one time step.
struct ContactStep {
    double dt = 0;       ///< s
    double spacing = 0;  ///< m, between boundary particles
    double gravity = 0;  ///< m/s^2, magnitude
    Domain domain;
    double clearance = 0;  ///< m, smallest gap between bodies and other solids; bodies that are already nearer may stay
};

/// For each free body in order: velocity of the centre and angular velocity [m/s, rad/s], or force and torque about the centre [N, N m].
using BodyVector = Eigen::VectorXd;
BodyVector velocities_of(const Solids& solids);

/// Contact as a condition on the bodies' velocities, for any solve that moves the bodies. At each point of contact
///   v_n >= -gap/dt,   impulse_n >= 0,   equality in at least one of them,   |impulse_t| <= friction impulse_n, opposite to v_t if equal
/// with v_n and v_t the normal and tangential parts of the relative velocity at the point.
///
/// Points of contact: from each boundary particle of a body near the other solid, a descent along the body's surface finds the deepest
/// point. Of a flat face only the points that bound it are kept. Friction acts nearer to the middle of the face than these points, such
/// that it brakes a spin about the normal as much as if the load were spread evenly over the face.
///
/// Impulses are equal and opposite, so momentum and angular momentum are conserved. They are found by projected Gauss-Seidel in a fixed
/// order. Overlaps shrink by a fifth per step, or by a fifth per 0.1 sqrt(d/g) if that is longer than a step (d: spacing, g: gravity).
/// A body bounces only if its approach speed exceeds that of a free fall over one spacing.
class BodyContacts {
public:
    /// Finds the points of contact for a step that starts from the bodies' current velocities.
    void find(const Solids& solids, const BoundaryParticles& boundary, const ContactStep& step);
    bool empty() const { return points_.empty(); }
    /// The velocities after contact. @param free the velocities that the bodies would have without contact
    BodyVector velocities(const BodyVector& free);
    /// Fixes the set of contacts for change(): those with an impulse in the last velocities(). A contact that did not slide then also has
    /// its tangential velocity held.
    void hold();
    /// The change of velocities() [m/s, rad/s] that the impulses f cause: M^-1 f - M^-1 J^T (J M^-1 J^T)^-1 J M^-1 f. J v are the relative
    /// velocities at the held contacts for the bodies' velocities v. M contains the masses and tensors of inertia. The map from f to the
    /// change is symmetric and positive semi-definite. @param impulses f [N s, N m s]
    BodyVector change(const BodyVector& impulses) const;
    /// The change of velocities that the impulses would cause without contact: M^-1 f.
    BodyVector free_change(const BodyVector& impulses) const { return lightness_ * impulses; }
    /// Replaces the bodies' velocities by those after contact. May be called again in the step: it first removes its earlier impulses.
    void resolve(Solids& solids);

private:
    /// A direction at a point of contact. An impulse in this direction acts on body a, the opposite impulse on b.
    struct Direction {
        Vec3d along;                         ///< unit vector
        Vec3d arm_a, arm_b = Vec3d::Zero();  ///< torque about the centre per unit impulse [m]; arm_b only if b is free
        Vec3d turn_a, turn_b;                ///< change of angular velocity per unit impulse [1/(kg m)]
        double softness = 0;                 ///< change of the relative velocity per unit impulse [1/kg]
        double impulse = 0, given = 0;       ///< impulse on a, and the part of it that resolve() has already applied [kg m/s]
    };
    /// A point of contact: a point on the surface of body `a` near the surface of solid `b`.
    struct Point {
        std::size_t a, b;
        std::array<Direction, 3> ways;       ///< the normal from b to a, and two tangents, for friction
        double crossed = 0;                  ///< change of velocity along one tangent per unit impulse along the other [1/kg]
        Vec3d place;                         ///< m
        Vec3d arm_a, arm_b = Vec3d::Zero();  ///< vectors from the centres to the point [m]; arm_b only if b is free
        Vec3d grip = Vec3d::Zero();          ///< vector from the point to the point at which friction acts [m]
        Vec3d wall = Vec3d::Zero();          ///< velocity of b if it is not free [m/s]
        double gap = 0;                      ///< m
        double wanted = 0;                   ///< smallest v_n that contact allows [m/s]
        double friction = 0;
        bool slides() const { return std::hypot(ways[1].impulse, ways[2].impulse) >= (1 - 1e-6) * friction * ways[0].impulse; }
    };
    /// A body while impulses act on it. Other solids have slot -1.
    struct Moving {
        Vec3d velocity = Vec3d::Zero(), turning = Vec3d::Zero();  ///< m/s, rad/s
        double lightness = 0;                                     ///< 1/kg
        Mat3d inverse_inertia = Mat3d::Zero();
        Eigen::Index slot = -1;  ///< position in a BodyVector
    };

    void look_from(const Solids& solids, const BoundaryParticles& boundary, std::size_t a, std::size_t b, Index s, const Vec3d& image);
    /// Thins out the points from index `first` on, which belong to one pair of solids. Of each flat face it keeps the points that bound
    /// the face and the deepest point, because the conditions at the others follow from these.
    void thin(std::size_t first);
    Vec3d deepest(const Solid& a, const Solid& b, const Vec3d& image, const Vec3d& start) const;
    void want(const Solids& solids);
    Direction direction(const Point& p, const Vec3d& along, const Vec3d& from_place) const;
    double speed(const Point& p, const Direction& n) const;
    void push(const Point& p, Direction& n, double impulse);
    double push_apart(Point& p);
    double hold_back(Point& p);
    /// Adds rows to J for the relative velocities that the points `first` to `last` - 1, of one pair of solids, hold at 0. Leaves out
    /// rows that are linearly dependent.
    void add_rows(std::size_t first, std::size_t last, std::vector<Eigen::Triplet<double>>& J) const;

    ContactStep step_;
    std::vector<Moving> moving_;  ///< by solid
    Eigen::Index slots_ = 0;
    std::vector<Point> points_;              ///< points of contact, in the order of the pairs of solids
    Eigen::SparseMatrix<double> lightness_;  ///< M^-1
    struct Held;
    std::shared_ptr<const Held> held_;  ///< null: no contact is held
};

}  // namespace whorl
