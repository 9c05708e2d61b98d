#pragma once
/// Probes of quantities that experiments measure (docs/physics.md 13).
#include "engine/probes/probes.h"

namespace whorl {

/// Height of the fluid's surface along the line from `from` to `to`, measured from its first point, exact to half a spacing, also at
/// walls. The line is followed from its start as long as it is in fluid, so drops above the surface do not count; it passes through
/// solids. 0: there is no fluid within a spacing of the line's start, or of the point at which it leaves the solid in which it starts. The
/// line's length: all of it is in fluid.
std::unique_ptr<Probe> make_level_probe(const ProbeKeys& keys);

/// Fluid that passes an opening: a disc, or a rectangle with the axes of an emitter's slot; in 2D a line, with volumes per metre of depth.
/// Every particle whose path in a step crosses the opening counts, positive along `direction`, negative against it. Totals are exact to
/// one particle; rates are means since the previous row. A particle that is removed in the step in which it crosses (by a drain or at the
/// domain's boundary) counts as having moved straight on. Particles in nozzles do not count. @param world its particles must have the
/// column `id`
std::unique_ptr<Probe> make_flux_probe(const ProbeKeys& keys, const World& world);

/// Front along `direction`, radius about the axis and height along it, relative to `axis_point`: the position of the outermost particle
/// plus half a spacing. Only the largest connected part of the fluid counts, not spray and drops. Along periodic axes the image nearest to
/// axis_point is used. Particles in nozzles do not count.
std::unique_ptr<Probe> make_extent_probe(const ProbeKeys& keys);

/// The flow in a box: energy, vorticity, and deviation from theory. largest_vorticity and mean_square_vorticity are of |curl u|, from
/// gradients by least squares over two spacings. expected_energy is the kinetic energy that the same particles would have with the
/// expected velocity v at their positions, and velocity_error is sqrt(sum |u - v|^2/sum |v|^2). Both are empty if v is zero; all columns
/// but the energy are empty if the box is.
std::unique_ptr<Probe> make_flow_probe(const ProbeKeys& keys);

/// Force of the fluid on a solid, from the ledger of momentum (Ledger). pressure_*, viscous_* and contact_* are means since the previous
/// row: impulse over time. torque_* is the torque of all three about the solid's centre: the centre of mass of a free body, otherwise the
/// middle of the shape's bounds. peak is the largest magnitude of the total force in a single step. In 2D forces are per metre of depth.
/// Cells are empty if no time has passed.
std::unique_ptr<Probe> make_solid_probe(const ProbeKeys& keys);

/// Pressure on a disc (2D: a line) on a solid's surface, with which the disc moves. Mean over the disc and over the time since the
/// previous row, from the impulses of all steps (Ledger), so discs that tile a wall add up to the pressure's part of its `solid` probe.
/// peak is the largest mean over the disc in a single step. Fluid that pulls gives negative values.
std::unique_ptr<Probe> make_gauge_probe(const ProbeKeys& keys, const World& world);

}  // namespace whorl
