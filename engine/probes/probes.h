#pragma once
/// Probes: what a scene asks to be measured while it runs, one CSV file each (probes/<name>.csv).
#include <iosfwd>
#include <memory>
#include <string>

#include "engine/probes/coil_expectation.h"
#include "engine/sim/simulation.h"

namespace whorl {

class Probe {
public:
    virtual ~Probe() = default;
    /// The header line, without the newline.
    virtual std::string header() const = 0;
    /// The scene that the run goes by now; before the rows of every frame.
    virtual void goes_by(const Scene&, const Plan&) {}
    /// Sees every step, after it was made; `time` is the step's end [s].
    virtual void after_step(const World&, double /*time*/) {}
    /// The lines of one frame, with their newlines.
    virtual std::string rows(const World& world, double time) = 0;
    /// What the probe remembers from step to step, for a checkpoint.
    virtual void save(std::ostream&) const {}
    virtual void load(std::istream&) {}
};

/// A probe of the scene. Only particles that are out of their nozzles count.
///   region  time,particles,mass,centroid_*,velocity_*,spin_*        means over the box; empty where no particle is inside, spin 0 where
///   none is kept point   time,velocity_*,density,pressure,...                    those quantities that the run keeps, interpolated; empty
///   where no fluid is near line    time,s,x,y,z,velocity_*,...                             `count` points from `from` to `to` a frame, s
///   [m] along the line coil
///   time,frequency,radius,turns,frequency_spread,radius_spread,pile_height,frequency_uncertainty,radius_uncertainty,fall,
///           theory_frequency,theory_radius   (coil_probe.h)
/// Point and line interpolate with the run's kernel, f(x) = sum f_j W_j / sum W_j (Shepard 1968): exact for a constant field, at a surface
/// too.
/// @param patience of the coil's theory
std::unique_ptr<Probe> make_probe(const ProbeKeys& keys, const World& world, Patience patience = Patience::waits);

/// The lines of a frame that the simulation has reached.
std::string rows_of(Probe& probe, const Simulation& simulation);

}  // namespace whorl
