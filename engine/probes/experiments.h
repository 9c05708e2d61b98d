#pragma once
/// Probes of quantities that experiments measure (docs/physics.md 13).
#include "engine/probes/probes.h"

namespace whorl {

/// Height of the fluid's surface along the line from `from` to `to`, measured from `from`. It is exact to half a spacing, also at walls.
/// The line is followed from its start as long as it is in fluid or in a solid, so drops above the surface do not count. The height is 0
/// if there is no fluid within a spacing of the line's start. If the start is in a solid, the point at which the line leaves the solid
/// takes its place. The height is the line's length if the whole line is in fluid.
std::unique_ptr<Probe> make_level_probe(const ProbeKeys& keys);

/// Fluid that passes an opening: a disc, or a rectangle with the axes of an emitter's slot; in 2D a line, with volumes per metre of depth.
/// Every particle whose path in a step crosses the opening counts, positive along `direction`, negative against it. Totals are exact to
/// one particle; rates are means since the previous row. A particle that is removed in the step in which it crosses (by a drain or at the
/// domain's boundary) counts as having moved straight on. Particles in nozzles do not count. @param world its particles must have the
/// column `id`
std::unique_ptr<Probe> make_flux_probe(const ProbeKeys& keys, const World& world);

/// Extent of the fluid relative to `axis_point`: front along `direction`, radius about the axis, and height along the axis. Each is the
/// position of the outermost particle plus half a spacing. Only the largest connected part of the fluid counts, not spray and drops. Along
/// periodic axes the image of a particle nearest to axis_point is used. Particles in nozzles do not count.
std::unique_ptr<Probe> make_extent_probe(const ProbeKeys& keys);

/// The flow in a box: energy, vorticity, and deviation from theory. largest_vorticity and mean_square_vorticity are the largest |curl u|
/// and the mean of |curl u|^2, from gradients by least squares over two spacings. expected_energy is the kinetic energy that the same
/// particles would have with the expected velocity v at their positions. velocity_error is sqrt(sum |u - v|^2/sum |v|^2). These two are
/// empty if v is zero. If no particle is in the box, only time, particles and kinetic_energy are not empty.
std::unique_ptr<Probe> make_flow_probe(const ProbeKeys& keys);

/// Force of the fluid on a solid, from the ledger of momentum (Ledger). pressure_*, viscous_* and contact_* are means since the previous
/// row: (impulse)/(time between the rows). torque_* is the sum of the torques of all three about the solid's centre: the centre of mass of
/// a free body, otherwise the middle of the shape's bounds. peak is the largest magnitude of the total force in a single step. In 2D forces
/// are per metre of depth. Cells are empty if no time has passed.
std::unique_ptr<Probe> make_solid_probe(const ProbeKeys& keys);

/// Pressure on a disc (2D: a line) that lies on a solid's surface and moves with the solid. It is the mean over the disc and over the time
/// since the previous row, from the impulses of all steps (Ledger). Forces on discs that tile a wall therefore add up to the force of
/// pressure that a `solid` probe of the wall reports. peak is the largest mean over the disc in a single step. Values are negative if the
/// fluid pulls.
std::unique_ptr<Probe> make_gauge_probe(const ProbeKeys& keys, const World& world);

}  // namespace whorl
