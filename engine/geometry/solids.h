#pragma once
/// Solids: shapes that are fixed, or move and turn by expressions, and the particles that sample their surfaces.
#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <optional>
#include <vector>

#include "engine/core/column.h"
#include "engine/geometry/repeats.h"
#include "engine/geometry/rigid_body.h"
#include "engine/math/expression.h"

namespace whorl {

/// Rotation of a solid with a time-dependent spin after whole intervals of the quadrature; follows from the expression alone.
struct Turned {
    long intervals = 0;
    Mat3d rotation = Mat3d::Identity();
};

/// The point that a solid turns about: the centre of the shape's bounds at its first position; of a plane, its point nearest to the
/// origin.
Vec3d turning_point(const Shape& shape);

/// The least box along a solid's own axes about the domain. Periodic axes stay so where one of the solid's axes lies along them.
Domain in_own_axes(const Domain& domain, const Pose& pose);

struct Solid {
    std::shared_ptr<const Shape> shape;
    VectorExpression position;  ///< m, of t: displacement from the shape's first position
    VectorExpression spin;      ///< rad/s about the own axes through turning_point(), of t
    bool inside = false;        ///< the fluid is inside the shape
    double slip_length = 0;     ///< m: u - u_wall = slip_length du/dn on the surface; 0: the fluid sticks, infinite: it slides freely
    std::string material;
    Contact contact;                 ///< how it touches other solids
    std::optional<RigidBody> body;   ///< free: forces move it; position and spin only say where it starts
    Vec3d shift = Vec3d::Zero();     ///< m, added to `position`; follows from earlier motions (go_on_as)
    Mat3d turn = Mat3d::Identity();  ///< before the turning by `spin` since t = 0: the scene's tilt, and the result of earlier motions
    Pose pose;
    Turned turned;
    Repeats repeats;      ///< of the shape in its pose
    bool probed = false;  ///< a probe reads a ledger: then all solids keep one, and it accounts for all of the fluid's momentum
    Ledger ledger;        ///< impulses of the fluid in this step; kept where keeps_ledger()
    double work = 0;      ///< of a driven solid on the fluid by these [J]

    /// Replaces position and spin from time t [s] on, continuing from the pose at that time.
    void go_on_as(VectorExpression new_position, VectorExpression new_spin, double t);
    bool moves() const;
    bool keeps_ledger() const { return probed || body; }
    /// Reference point of torques [m]: a free body's centre of mass, else where turning_point() is now.
    Vec3d centre() const;
    /// Adds the fluid's impulse to the ledger, and its work; a free body takes it up.
    void receive(Push kind, const Wrench& impulse);
    /// Velocity of turning_point() [m/s].
    Vec3 centre_velocity() const { return pose.velocity_at(centre().cast<Real>()); }
    bool sticks() const { return slip_length == 0; }
    /// The fluid slips, but not freely.
    bool partial_slip() const { return slip_length > 0 && slip_length < std::numeric_limits<double>::infinity(); }
    /// Distance from x to the solid's surface, positive on the fluid's side [m]; in a periodic domain to that of its nearest image.
    Real distance(const Vec3& x) const;
    /// Unit vector from the solid into the fluid.
    Vec3 normal(const Vec3& x) const;
    /// x moved by whole periods to where the solid's nearest image is seen as the solid itself.
    Vec3 image(const Vec3& x) const;
    /// Velocity of the solid's nearest image at x [m/s].
    Vec3 velocity_at(const Vec3& x) const { return pose.velocity_at(image(x)); }

private:
    Real own_distance(const Vec3& x) const { return shape->distance(pose.rotation.transpose() * (x - pose.translation)); }
    Real nearest_image(const Vec3& x, Vec3& image) const;
};

/// All solids of a run, moved together.
class Solids {
public:
    std::vector<Solid> all;
    Domain domain;  ///< whose periodic axes repeat the solids
    /// Sets every pose for time t; velocities such that the pose at t + dt is reached when dt has passed. Depends on t and dt alone, not on
    /// earlier calls: the same bits after a resume.
    void set_time(double t, double dt);
    /// The solid whose surface is nearest to x, -1 where there is none; distance on the fluid's side.
    int nearest(const Vec3& x, Real& distance) const;
    bool any_moving() const;
    bool any_free() const;
    bool any_ledger() const;
    bool any_probed() const;
    /// At the start of a step.
    void clear_ledgers();
    /// Poses and velocities of the free bodies as their states say.
    void place_bodies();

private:
    void place_images();
};

/// BoundaryParticles::flat at a distance from the nearest surface that is not flat [m].
inline Real flat_beside(Real distance, Real support) { return std::clamp(distance / support - 1, Real(0), Real(1)); }

/// Boundary particles: one layer on the solids' surfaces, about a spacing apart, half a spacing inside the solid.
struct BoundaryParticles {
    std::vector<Index> solid;         ///< whose
    Column<Vec3> own_position;        ///< in the solid's axes, m
    Column<Vec3> own_normal;          ///< in the solid's axes, into the fluid; empty: normals stay as they are
    Column<Vec3> position, velocity;  ///< m, m/s, in the world's axes
    Column<Vec3> normal;              ///< into the fluid
    Column<Real> volume;              ///< 1/sum W over the solid particles near by, m^3 (Akinci et al. 2012)
    Column<Real> behind;              ///< how much of a kernel the solid behind it fills, over that of a flat wall; 0: an edge
    Column<Vec3> own_face, face;      ///< on convex edges: SurfaceSample::face; elsewhere 0
    /// Weight of a flat wall's images of the fluid: 1 farther than 2 R from where the surface bends, ends or opens and from solids that
    /// move, 0 nearer than R. The surface may end at others at right angles that face the fluid, too; -1: where they meet. Empty: none is
    /// flat.
    Column<Real> flat;
    /// Impulse of the fluid's pressure and contact on each in this step [N s], on solids that keep a ledger; empty: no probe asks for it.
    std::vector<Vec3d> pressed;
    Index size() const { return static_cast<Index>(solid.size()); }
    /// Moves the particles with their solids.
    void follow(const Solids& solids);
    /// Removes the particles for which `out` is not 0.
    void remove(const std::vector<char>& out);
};

}  // namespace whorl
