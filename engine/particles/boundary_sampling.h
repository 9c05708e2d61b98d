#pragma once
/// Boundary particles: one layer that represents the solids' surfaces.
#include <functional>

#include "engine/core/errors.h"
#include "engine/geometry/domain.h"
#include "engine/geometry/plane.h"
#include "engine/geometry/solids.h"
#include "engine/math/kernel.h"
#include "engine/particles/step_context.h"

namespace whorl {

/// Samples every solid's surface about a spacing apart, half a spacing deep in the solid (less where the solid is thinner), in its present
/// pose; in a domain without depth the line in which its plane cuts the surface. Boxes: a lattice on the faces with their edges. Spheres: a
/// spiral. Cylinders: rings. Planes: a lattice. Meshes: blue noise by throwing darts; the same
/// for the same mesh. A box or plane that spans a periodic axis has no seam there. Parts farther than three spacings outside the
/// domain are left out unless the solid moves; of a moving plane, parts that do not meet the domain until `end`.
/// @param support of the volumes' kernel [m]; 0: two spacings
/// @param place_of a solid's place in the scene file, for messages
/// @param end s, of the run
/// @throws InputError if the layer of a solid would need more than 50 million particles
BoundaryParticles sample_solids(const Solids& solids, Real spacing, const Domain& domain, KernelForm kernel = {}, Real support = 0,
                                const std::function<FileLocation(std::size_t)>& place_of = {}, double end = 0);

/// The part of a moving plane that needs boundary particles: where it meets the domain, and twice the support [m] about it, at any time
/// until `end` [s]; of one that does not turn also where the domain is at first, seen along the normal. Periodic axes are filled where the
/// plane keeps them. The particles of a longer run include those of a shorter one.
/// @param plane in its pose at t = 0
PlanePatch patch_of_moving_plane(const Solid& plane, Real spacing, const Domain& domain, Real support, double end);

/// V_s = 1 / sum_s' W_ss', s itself included (Akinci et al. 2012) [m^D]. Solids that move count their own particles only, so that a volume
/// stays as it is.
void set_solid_volumes(BoundaryParticles& particles, const Solids& solids, const Domain& domain, KernelForm kernel, Real support);

/// Fills BoundaryParticles::flat of a layer as it was sampled, or leaves it empty if no wall is flat.
void find_flat_walls(BoundaryParticles& particles, const Solids& solids, const StepContext& step);

}  // namespace whorl
