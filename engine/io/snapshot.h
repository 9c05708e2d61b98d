#pragma once
/// From a running simulation to an immutable Frame.
#include "engine/core/mesh.h"
#include "engine/io/frame.h"
#include "engine/particles/emitter.h"
#include "engine/simulation/simulation.h"
#include "engine/simulation/world.h"

namespace whorl {

/// Adds those of `fields` that are derived and that the run can give:
/// vorticity:        curl u [1/s], from gradients by least squares over the neighbours: exact for linear velocities, at surfaces too
/// q_criterion:      Q [1/s^2], where the flow turns more than it strains (q_criterion())
/// spin_difference:  w - curl u/2 [1/s], the spin relative to the flow around it; if the run has spins
void add_derived_fields(const World& world, const std::vector<std::string>& fields, Frame& frame);

/// grad u of every particle [1/s], row: component of u; 0 where a particle is alone.
Column<Mat3> velocity_gradients(Span<const Vec3> x, Span<const Vec3> u, Real support, const Domain& domain);
/// (|W|^2 - |S|^2)/2 [1/s^2], S and W the symmetric and the antisymmetric part of a velocity gradient: positive in vortices (Hunt, Wray and
/// Moin 1988).
Real q_criterion(const Mat3& gradient);
/// curl u of every particle [1/s]; 0 where a particle is alone.
Column<Vec3> vorticity(Span<const Vec3> x, Span<const Vec3> u, Real support, const Domain& domain);

/// Takes frames of one run; keeps the solids' meshes, which every frame shares.
class Snapshots {
public:
    /// @param fields columns to copy in addition to position and velocity, by their names in files, and derived ones (derived_fields.h);
    /// those that the run does not have are left out
    Snapshots(const Simulation& simulation, std::vector<std::string> fields);

    /// All particles, also those inside a nozzle, so that the surface reaches into it; solids and nozzles at their current poses.
    Frame take(const Simulation& simulation, int number) const;

private:
    std::vector<std::string> fields_;
    std::vector<FrameSolid> solids_;  ///< the nozzles behind the solids; poses are filled in by take()
    std::vector<FrameEmitter> emitters_;
};

/// The particles' part of a frame.
Frame particles_of(const World& world, const std::vector<std::string>& fields);

/// A tube around an emitter's opening: the wall is half a spacing outside the fluid, the tube reaches `length` [m] back from the
/// opening.
TriangleMesh nozzle_mesh(const EmitterShape& opening, Real spacing, Real length);

}  // namespace whorl
