#pragma once
/// Emitters: openings through which fluid enters without gaps or overlaps, at any speed and time step.
#include <iosfwd>
#include <vector>

#include "engine/math/expression.h"
#include "engine/particles/nozzle.h"
#include "engine/particles/store.h"

namespace whorl {

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
