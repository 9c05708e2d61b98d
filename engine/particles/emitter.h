#pragma once
/// Emitters: openings through which fluid enters without gaps or overlaps, at any speed and time step.
#include <Eigen/Geometry>
#include <cmath>
#include <iosfwd>
#include <vector>

#include "engine/geometry/solids.h"
#include "engine/math/expression.h"
#include "engine/particles/store.h"

namespace whorl {

struct EmitterShape {
    bool slot = false;                ///< a rectangle, width x thickness; otherwise a disc
    Vec3 centre = Vec3::Zero();       ///< centre of the opening [m]
    Vec3 direction = -Vec3::UnitY();  ///< direction of the flow, unit vector
    Real radius = 0;                  ///< m
    Real width = 0, thickness = 0;    ///< m
    bool parabolic = false;           ///< parabolic profile; otherwise a plug
    bool plane = false;               ///< 2D flow: a slot of width `width` in the plane z = 0, one metre deep

    /// The opening with its rim moved inward by `by` [m].
    EmitterShape narrower(Real by) const;
};

/// Unit axes of the opening: `width` along a slot's width (horizontal; along x if the flow is vertical) and `thickness` along its
/// thickness, with width x thickness = -direction. In 2D `thickness` is z.
inline void opening_axes(const EmitterShape& opening, Vec3& width, Vec3& thickness) {
    const Vec3 back = -opening.direction;
    if (opening.plane) {
        width = Vec3::UnitZ().cross(back), thickness = Vec3::UnitZ();
        return;
    }
    width = std::abs(back.y()) < Real(0.9) ? Vec3(Vec3::UnitY().cross(back)) : Vec3(Vec3::UnitX() - back.x() * back);
    width.normalize();
    thickness = back.cross(width);
}

/// Number of particles in the column that a nozzle repeats. For the streamlines of a parabolic profile it is one layer. For a plug it is 24
/// layers, or fewer (at least 6) if 24 layers would contain more than a hundred thousand particles.
/// @param area area of the opening [m^2]; in 2D its width [m]
double column_points(double area, double spacing, bool parabolic, int dimensions);

/// The pipe behind an opening: `depth` [m] of fluid, and a closed end of least_clearance spacings, which keeps other fluid away from the
/// places at which particles enter. @param domain its periodic axes repeat the pipe
Solid nozzle_body(const EmitterShape& opening, Real depth, Real spacing, const Domain& domain);
/// A wider and longer version of the end of that pipe, in which new particles appear. It keeps other fluid so far away that new particles
/// cause no jump of the density of that fluid.
Solid nozzle_end(const EmitterShape& opening, Real depth, Real spacing, const Domain& domain);
/// Length of that pipe [m], such that a particle at the opening has a complete neighbourhood.
inline Real nozzle_depth(double support, double spacing) { return static_cast<Real>(support + spacing); }

/// Pushes an endless column of blue-noise fluid through an opening. A buffer of `depth` [m] behind the opening contains particles that are
/// already in the store, with prescribed velocity (role -k), so that fluid at the opening has a complete neighbourhood. Other fluid is
/// kept out of the pipe: if some comes near before `start`, the buffer is filled and at rest.
class Emitter {
public:
    /// @param number 1, 2, ...: particles in this nozzle have the role -number
    /// @param domain its periodic axes repeat the pipe
    /// @param narrower width of the rim that solids cover [m]; the same volume then flows through the rest, faster
    Emitter(EmitterShape shape, Expression speed, double start, double stop, Real spacing, Real depth, int number, std::uint64_t seed,
            const Domain& domain = {}, Real narrower = 0);

    /// Lets the opening move, with the fluid in the pipe: `position` [m] is its centre and `direction` that of the flow (of any length), as
    /// functions of t [s]; at t = 0 they are those of the constructor. The opening turns with `direction` by the smallest rotation.
    void follow(VectorExpression position, VectorExpression direction);
    /// Brings the opening to its place at time t.
    void set_time(double t);
    /// Call at the start of a step. Fills the buffer with new particles (their other lasting columns are zero) and sets the velocity of
    /// its particles for [t, t + dt]. The move stage then moves them like all others.
    void enter(ParticleStore& fluid, double t, double dt);
    /// Call after the move, with the time at its end. Particles beyond the opening become free (role 0), with the velocity of the flow plus
    /// that of the opening. @return their number
    Index release(ParticleStore& fluid, double t);

    /// Call after release(). Free particles that have entered the pipe are moved to its wall, and lose the component of their velocity
    /// into it.
    void keep_out(ParticleStore& fluid) const;
    /// For a pipe in fluid: makes the pipe full from the start. @param places positions of the particles in the pipe and of those at rest
    /// around its end
    void be_full(std::vector<Vec3> places);
    bool is_full() const;
    /// Stops the flow from time t [s] on.
    void close(double t);
    /// Whether fluid at x cannot be free, because it is in the pipe or would be moved to its wall.
    bool takes(const Vec3& x) const;
    /// Signed distance from x to the pipe [m], negative inside.
    Real distance(const Vec3& x) const;
    /// Positions of the particles that fill the pipe at the start.
    std::vector<Vec3> filling() const;

    /// Volume that has passed the opening (the integral of the speed, not a count) over the volume of a particle.
    double expected_particles() const;
    /// Largest speed of the flow relative to the opening at time t [m/s].
    double speed(double t) const;
    /// The opening at the last time that was set.
    const EmitterShape& shape() const;
    /// Displacement and rotation of the opening since t = 0, with their rates.
    const Pose& pose() const;

    /// Changes speed and times from now on. The emitted volume is kept, so the column continues without a gap.
    void change(Expression speed, double start, double stop);

    void save(std::ostream&) const;
    /// @return whether the state is possible for this emitter @throws EnvironmentError if the data end too early
    bool load(std::istream&);
    ~Emitter();
    Emitter(Emitter&&) noexcept;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace whorl
