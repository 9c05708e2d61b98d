#pragma once
/// Probes of quantities that experiments measure (docs/physics.md 13).
#include "engine/probes/probes.h"

namespace whorl {

/// Height of the surface along the line from `from` to `to`, counted from its first point: exact to half a spacing, also at walls. The
/// line is followed from there as long as it is in fluid, so drops above the surface do not count; solids on the way are passed. 0: no
/// fluid is within a spacing of where the line begins, or leaves the solid that it begins in; its length: all of it is in fluid.
std::unique_ptr<Probe> make_level_probe(const ProbeKeys& keys);

/// Fluid that passes an opening: a disc, or a rectangle whose axes are those of an emitter's slot; in two dimensions a line, and volumes of
/// a metre of depth. Every particle whose path in a step crosses it counts, along `direction` or negative against it. Totals are exact to
/// one particle; rates are means since the row before. A particle that is taken away in the step in which it crosses (by a drain, at the
/// domain's end) has gone straight on. Particles in nozzles do not count. @param world its particles have the column `id`
std::unique_ptr<Probe> make_flux_probe(const ProbeKeys& keys, const World& world);

/// Front along `direction`, radius about the axis and height along it, from `axis_point`: of the outermost particle, and half a spacing
/// more. The fluid is its largest connected part, so spray and drops do not count. Along periodic axes places are those nearest to
/// axis_point. Particles in nozzles do not count.
std::unique_ptr<Probe> make_extent_probe(const ProbeKeys& keys);

/// The flow in a box: energy, vorticity, and its distance from theory. largest_vorticity and mean_square_vorticity are of
/// |curl u|, from gradients by least squares over two spacings. expected_energy is the kinetic energy that the same particles would have
/// with the expected velocity v where they are, and velocity_error is sqrt(sum |u - v|^2/sum |v|^2). Both are empty where v is zero, and
/// all but the energy where the box is empty.
std::unique_ptr<Probe> make_flow_probe(const ProbeKeys& keys);

/// Force of the fluid on a solid, from the ledger of momentum (Ledger). pressure_*, viscous_* and contact_* are means since the
/// row before: impulse over time. torque_* is that of all three about the solid's centre: a free body's centre of mass, else the middle of
/// the shape's bounds. peak is the largest size of the total force of a single step. In two dimensions forces are those on a metre of
/// depth. Empty cells: no time has passed.
std::unique_ptr<Probe> make_solid_probe(const ProbeKeys& keys);

/// Pressure on a disc of a solid's surface, with which it moves; in two dimensions on a line. The mean over disc and time since the row
/// before, from the impulses of all steps (Ledger), so discs that tile a wall add up to the pressure's part of its `solid`
/// probe; and the peak, the largest mean over the disc in a step. Fluid that pulls makes them negative.
std::unique_ptr<Probe> make_gauge_probe(const ProbeKeys& keys, const World& world);

}  // namespace whorl
