#pragma once
/// Solids: shapes that are fixed, move by expressions or are moved by forces, and the particles that sample their surfaces.
#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <optional>
#include <vector>

#include "engine/core/column.h"
#include "engine/geometry/motion.h"
#include "engine/geometry/repeats.h"
#include "engine/geometry/rigid_body.h"
#include "engine/math/expression.h"

namespace whorl {

/// Rotation of a solid with a time-dependent spin after a whole number of fixed intervals. It depends only on the spin's expression.
struct Turned {
    long intervals = 0;
    Mat3d rotation = Mat3d::Identity();
};

/// The point about which a solid turns: the centre of the shape's bounds at its initial position. For a plane, the point of the plane
/// that is nearest to the origin.
Vec3d turning_point(const Shape& shape);

/// The smallest box along a solid's own axes that contains the domain. A periodic axis stays periodic if an own axis is parallel to it.
Domain in_own_axes(const Domain& domain, const Pose& pose);

struct Solid {
    std::shared_ptr<const Shape> shape;
    VectorExpression position;                    ///< displacement from the shape's initial position [m], a function of t
    VectorExpression spin;                        ///< angular velocity about the own axes through the pivot [rad/s], a function of t
    std::function<MotionState(double t)> motion;  ///< if set, gives the rotation, of which `spin` is the rate
    std::optional<Vec3d> own_pivot;  ///< the point about which the solid turns, at the shape's initial position [m]; empty: turning_point()
    bool inside = false;             ///< the fluid is inside the shape
    double slip_length = 0;          ///< m, in u - u_wall = slip_length du/dn on the surface; 0: no slip, infinite: free slip
    Contact contact;                 ///< contact with other solids
    std::optional<RigidBody> body;   ///< set for a free body, which forces move; position and spin then only give its initial pose
    Vec3d shift = Vec3d::Zero();     ///< added to `position` [m]; the result of earlier motions (go_on_as)
    Mat3d turn =
        Mat3d::Identity();  ///< rotation applied after the rotation by `spin` since t = 0: the scene's tilt, results of earlier motions
    Pose pose;
    Turned turned;
    Repeats repeats;      ///< periodic images of the shape in its pose
    bool probed = false;  ///< whether a probe or the energy budget needs this solid's ledger. A probe sets it for all solids, so that the
                          ///< ledgers account for all of the fluid's momentum
    Ledger ledger;        ///< impulses of the fluid in this step, recorded if keeps_ledger()
    double work = 0;      ///< work of a driven solid on the fluid in this step, from the ledger [J]

    /// Replaces position and spin from time t [s] on. The motion continues from the pose at that time.
    void go_on_as(VectorExpression new_position, VectorExpression new_spin, double t);
    bool moves() const;
    bool keeps_ledger() const { return probed || body; }
    Vec3d pivot() const { return own_pivot ? *own_pivot : turning_point(*shape); }
    /// Reference point of torques [m]: the centre of mass of a free body, otherwise the current position of the pivot.
    Vec3d centre() const;
    /// Adds an impulse of the fluid to the ledger, with its work; a free body also changes its momentum.
    void receive(Push kind, const Wrench& impulse);
    /// Velocity of centre() [m/s].
    Vec3 centre_velocity() const { return pose.velocity_at(centre().cast<Real>()); }
    bool sticks() const { return slip_length == 0; }
    /// Whether the fluid slips with friction, so it neither sticks nor slides freely.
    bool partial_slip() const { return !sticks() && !slides_freely(); }
    bool slides_freely() const { return slip_length == std::numeric_limits<double>::infinity(); }
    /// Distance from x to the solid's surface, positive on the fluid's side [m]. In a periodic domain, the distance to the nearest image.
    Real distance(const Vec3& x) const;
    /// Unit vector from the solid into the fluid.
    Vec3 normal(const Vec3& x) const;
    /// x moved by whole periods, such that the solid's nearest image becomes the solid itself.
    Vec3 image(const Vec3& x) const;
    /// Velocity of the solid's nearest image at x [m/s].
    Vec3 velocity_at(const Vec3& x) const { return pose.velocity_at(image(x)); }

private:
    Real own_distance(const Vec3& x) const { return shape->distance(pose.rotation.transpose() * (x - pose.translation)); }
    Real nearest_image(const Vec3& x, Vec3& image) const;
};

/// All solids of a run.
class Solids {
public:
    std::vector<Solid> all;
    Domain domain;  ///< its periodic axes repeat the solids
    /// Sets every pose for time t, with velocities such that the pose at t + dt is reached after dt. The result depends only on t and dt,
    /// not on earlier calls, so a resumed run is bit-identical.
    void set_time(double t, double dt);
    /// Index of the solid whose surface is nearest to x, -1 if there are no solids. @param distance positive on the fluid's side [m]
    int nearest(const Vec3& x, Real& distance) const;
    bool any_moving() const;
    bool any_free() const;
    bool any_ledger() const;
    bool any_probed() const;
    /// Clears all ledgers. Call at the start of a step.
    void clear_ledgers();
    /// Sets the poses and velocities of the free bodies from their states.
    void place_bodies();

private:
    void place_images();
};

/// The value of BoundaryParticles::flat at the given distance [m] from the nearest place where the wall is not flat.
inline Real flat_beside(Real distance, Real support) { return std::clamp(distance / support - 1, Real(0), Real(1)); }

/// Boundary particles: one layer on the solids' surfaces, about a spacing apart, half a spacing inside the solid.
struct BoundaryParticles {
    std::vector<Index> solid;         ///< index of each particle's solid
    Column<Vec3> own_position;        ///< position in the solid's own axes [m]
    Column<Vec3> own_normal;          ///< normal in the solid's own axes, into the fluid; empty: normals are not updated
    Column<Vec3> position, velocity;  ///< position and velocity in world axes [m, m/s]
    Column<Vec3> normal;              ///< unit normal in world axes, into the fluid
    Column<Real> volume;              ///< 1/sum W over the neighbouring boundary particles [m^3] (Akinci et al. 2012)
    Column<Real> behind;              ///< fraction of the kernel that the solid fills, relative to a flat wall; 0: an edge
    Column<Vec3> own_face, face;      ///< SurfaceSample::face on convex edges, elsewhere 0; in own and in world axes
    /// Weight of the fluid's mirror images behind a flat wall (R: support radius). It is 1 farther than 2 R from all bends, ends and
    /// openings of the surface and from solids that move, and 0 nearer than R. Ends at another surface, at a right angle that faces the
    /// fluid, do not count; on such a corner the weight is -1. Empty: no wall is flat.
    Column<Real> flat;
    /// Impulse of the fluid's pressure and contact on each particle in this step [N s], for solids that keep a ledger. Empty: no probe
    /// needs it.
    std::vector<Vec3d> pressed;
    Index size() const { return static_cast<Index>(solid.size()); }
    /// Moves the particles with their solids.
    void follow(const Solids& solids);
    /// Removes the particles for which `out` is not 0.
    void remove(const std::vector<char>& out);
};

}  // namespace whorl
