#pragma once
/// Boundary particles: one layer of particles that represents the solids' surfaces.
#include <functional>

#include "engine/core/errors.h"
#include "engine/geometry/domain.h"
#include "engine/geometry/plane.h"
#include "engine/geometry/solids.h"
#include "engine/math/kernel.h"
#include "engine/particles/step_context.h"

namespace whorl {

/// Samples every solid's surface in its current pose, with points about one spacing apart, half a spacing deep in the solid (less in thin
/// solids). In 2D it samples the curve in which the plane z = 0 cuts the surface. Box and plane: a lattice. Sphere: a spiral. Cylinder:
/// rings. Mesh: blue noise by throwing darts; equal meshes get equal points. A box or plane that spans a periodic axis has no seam there.
/// Of solids at rest, parts farther than three spacings outside the domain are left out. Of moving planes, parts that do not meet the
/// domain before `end` are left out.
/// @param support kernel radius for the volumes [m]; 0: two spacings
/// @param place_of location of a solid in the scene file, for messages
/// @param end end of the run [s]
/// @throws InputError if a solid needs more than 50 million particles
BoundaryParticles sample_solids(const Solids& solids, Real spacing, const Domain& domain, KernelForm kernel = {}, Real support = 0,
                                const std::function<FileLocation(std::size_t)>& place_of = {}, double end = 0);

/// The part of a moving plane that needs boundary particles: where it is within twice the support [m] of the domain at any time until
/// `end` [s]. For a plane that does not turn, also the domain's initial projection along the normal. Periodic axes that stay in the plane
/// are filled. The particles of a longer run include those of a shorter one.
/// @param plane in its pose at t = 0
PlanePatch patch_of_moving_plane(const Solid& plane, Real spacing, const Domain& domain, Real support, double end);

/// Sets the volumes V_s = 1/sum_s' W_ss' (Akinci et al. 2012) [m^D, D dimensions]. The sum is over boundary particles s', including s
/// itself. For a solid that moves it includes only particles of that solid, so that its volumes stay constant.
void set_solid_volumes(BoundaryParticles& particles, const Solids& solids, const Domain& domain, KernelForm kernel, Real support);

/// Joins the surfaces of solids at rest that touch or overlap, of which one at least is bounded with the fluid outside: removes the newly
/// sampled particles that another solid covers, takes the components into another solid out of the normals of edges that lie against it,
/// and sets the volumes.
void join_surfaces(BoundaryParticles& particles, const Solids& solids, const StepContext& step);

/// Fills BoundaryParticles::flat of newly sampled particles, or leaves it empty if no wall is flat.
void find_flat_walls(BoundaryParticles& particles, const Solids& solids, const StepContext& step);

}  // namespace whorl
