#pragma once
/// From a running simulation to an immutable Frame.
#include "engine/io/frame.h"
#include "engine/sim/simulation.h"

namespace whorl {

/// Takes frames of one run; keeps the solids' meshes, which every frame shares.
class Snapshots {
public:
    /// @param fields columns besides position and velocity to copy, by their names in files, and derived ones (derived_fields.h); those
    /// that the run does not have are left out
    Snapshots(const Simulation& simulation, std::vector<std::string> fields);

    /// All particles, those inside a nozzle too, so that the surface runs up into it; solids and nozzles where they stand now.
    Frame take(const Simulation& simulation, int number) const;

private:
    std::vector<std::string> fields_;
    std::vector<FrameSolid> solids_;  ///< the nozzles behind the solids; poses are filled in by take()
    std::vector<FrameEmitter> emitters_;
};

/// The particles' part of a frame.
Frame particles_of(const World& world, const std::vector<std::string>& fields);

}  // namespace whorl
