#pragma once
/// Makes an immutable Frame of a running simulation.
#include "engine/core/mesh.h"
#include "engine/io/frame.h"
#include "engine/particles/emitter.h"
#include "engine/simulation/simulation.h"
#include "engine/simulation/world.h"

namespace whorl {

/// Adds the derived fields among `fields`, as far as they exist in the run.
///
/// "vorticity" is curl u [1/s], by least squares over the neighbours; it is exact for linear velocities, also at surfaces.
///
/// "q_criterion" is q_criterion() [1/s^2], positive where rotation exceeds strain.
///
/// "spin_difference" is w - curl u/2 [1/s], the spin w relative to the surrounding flow; it exists only if the run has spins.
void add_derived_fields(const World& world, const std::vector<std::string>& fields, Frame& frame);

/// grad u of every particle [1/s], with one row per component of u; 0 for a particle without neighbours.
Column<Mat3> velocity_gradients(Span<const Vec3> x, Span<const Vec3> u, Real support, const Domain& domain);
/// Q = (|W|^2 - |S|^2)/2 [1/s^2], with the symmetric part S and the antisymmetric part W of a velocity gradient. Q is positive in vortices
/// (Hunt, Wray and Moin 1988).
Real q_criterion(const Mat3& gradient);
/// curl u of every particle [1/s]; 0 for a particle without neighbours.
Column<Vec3> vorticity(Span<const Vec3> x, Span<const Vec3> u, Real support, const Domain& domain);

/// Makes frames of one run. Keeps the solids' meshes, which all frames share.
class Snapshots {
public:
    /// @param fields names of the fields to copy in addition to position and velocity: columns, by their names in files, and derived fields
    /// (add_derived_fields()). Fields that the run does not have are left out
    Snapshots(const Simulation& simulation, std::vector<std::string> fields);

    /// Keeps those meshes of the same run's earlier snapshots that did not change, because a renderer prepares every new mesh.
    void share_meshes(const Snapshots& earlier);
    /// A frame of all particles, with solids and nozzles in their current poses. It includes particles inside nozzles, so that the fluid's
    /// surface reaches into the nozzle.
    Frame take(const Simulation& simulation, int number) const;

private:
    std::vector<std::string> fields_;
    std::vector<FrameSolid> solids_;  ///< the solids, then the nozzles; take() sets the poses
};

/// The part of a frame that describes particles.
Frame particles_of(const World& world, const std::vector<std::string>& fields);

/// A tube around an emitter's opening. Its wall is half a spacing outside the fluid, and it reaches `length` [m] back from the opening.
TriangleMesh nozzle_mesh(const EmitterShape& opening, Real spacing, Real length);

}  // namespace whorl
