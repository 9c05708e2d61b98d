#pragma once
/// Emitters: openings through which fluid enters without gaps or pairs, at any speed and time step.
#include <Eigen/Geometry>
#include <cmath>
#include <iosfwd>
#include <vector>

#include "engine/geometry/solids.h"
#include "engine/math/expression.h"
#include "engine/particles/store.h"

namespace whorl {

struct EmitterShape {
    bool slot = false;                ///< a rectangle, width x thickness, rather than a disc
    Vec3 centre = Vec3::Zero();       ///< m, of the opening
    Vec3 direction = -Vec3::UnitY();  ///< unit, the way the fluid goes
    Real radius = 0;                  ///< m
    Real width = 0, thickness = 0;    ///< m
    bool parabolic = false;           ///< else a plug
    bool plane = false;               ///< a flow of two dimensions: a slot in the plane z = 0, `width` wide, of a metre of depth

    /// The opening without a rim of `by` [m].
    EmitterShape narrower(Real by) const;
};

/// Unit axes of the opening's plane: a slot's width lies along `width` (horizontal; along x where the fluid goes straight up or down),
/// its thickness along `thickness`; width x thickness = -direction. In the plane thickness is z.
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

/// Particles in the column that a nozzle repeats: a layer for the streamlines of a parabolic profile, 24 for a plug, down to 6 where the
/// opening is so wide that these hold a hundred thousand. @param area of the opening [m^2], in 2D its width [m]
double column_points(double area, double spacing, bool parabolic, int dimensions);

/// The pipe behind an opening: `depth` [m] of fluid, and an end of least_clearance spacings, so that fluid behind it is not where particles
/// come in.
/// @param domain whose periodic axes repeat it
Solid nozzle_body(const EmitterShape& opening, Real depth, Real spacing, const Domain& domain);
/// Wider and longer end of that pipe, at which new particles appear: from there other fluid is too far away to feel a jump of its density.
Solid nozzle_end(const EmitterShape& opening, Real depth, Real spacing, const Domain& domain);
/// Length of that pipe [m]: a particle at the opening must find its whole neighbourhood.
inline Real nozzle_depth(double support, double spacing) { return static_cast<Real>(support + spacing); }

/// Pushes an endless column of blue-noise fluid through an opening. A buffer of `depth` [m] above the opening holds particles that are
/// already in the store with their velocity prescribed (role -k): neighbours find a full neighbourhood at the exit. Other fluid stays out
/// of the pipe: where some comes near it before `start`, the buffer is there and at rest.
class Emitter {
public:
    /// @param number 1, 2, ...: particles in this nozzle carry the role -number
    /// @param domain whose periodic axes repeat the pipe
    /// @param narrower rim of the opening that solids take [m]; as much comes through the rest, faster
    Emitter(EmitterShape shape, Expression speed, double start, double stop, Real spacing, Real depth, int number, std::uint64_t seed,
            const Domain& domain = {}, Real narrower = 0);

    /// Call at the start of a step: fills the buffer with particles (other lasting columns of new particles start at zero), and sets the
    /// velocity that its particles have during [t, t + dt]. The step's own move stage then moves them like all others.
    void enter(ParticleStore& fluid, double t, double dt);
    /// Call after the move: particles beyond the opening become free (role 0). Returns how many.
    Index release(ParticleStore& fluid, double t) const;

    /// Call after release(): free particles that have come into the pipe are put back on its wall and lose the part of their velocity that
    /// points into it.
    void keep_out(ParticleStore& fluid) const;
    /// The pipe lies in fluid: it is full from the first on. @param places of its particles, and of those that rest around its end
    void be_full(std::vector<Vec3> places);
    bool is_full() const;
    /// Nothing is pushed from time t [s] on.
    void close(double t);
    /// Whether fluid at x cannot be free: it is in the pipe, or would be put back on its wall.
    bool takes(const Vec3& x) const;
    /// From x to the pipe [m], negative inside.
    Real distance(const Vec3& x) const;
    /// Positions of the particles that fill the pipe at the start.
    std::vector<Vec3> filling() const;

    /// Volume that has passed the opening (the integral of the speed, not a count) over the volume of a particle.
    double expected_particles() const;
    /// Largest speed at time t [m/s], for the time step.
    double speed(double t) const;
    const EmitterShape& shape() const;

    /// Changes speed and times from now on. The emitted volume is kept: the column continues without a gap.
    void change(Expression speed, double start, double stop);

    void save(std::ostream&) const;
    /// @return whether the state is one that this emitter can have @throws EnvironmentError if the data are cut short
    bool load(std::istream&);
    ~Emitter();
    Emitter(Emitter&&) noexcept;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace whorl
