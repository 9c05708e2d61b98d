#pragma once
/// Fills shapes with particles.
#include <functional>
#include <vector>

#include "engine/core/random.h"
#include "engine/geometry/domain.h"
#include "engine/geometry/shape.h"

namespace whorl {

/// Smallest distance of a particle from a solid or a pipe when it is placed [spacings].
inline constexpr double least_clearance = 0.45;

enum class Sampling { lattice, jittered, blue_noise };
/// Number of layers of a lattice along an axis. nearest: the shape's length in spacings, rounded. within: the number that fits if the outer
/// layers are half a spacing inside the shape (at least least_clearance spacings).
enum class Layers { nearest, within };

/// Signed distance [m], negative inside.
using Distance = std::function<Real(const Vec3&)>;

/// Positions that fill the shape, one per volume spacing^3 (2D: per area spacing^2). Equal seeds give equal positions. Positions beyond a
/// periodic face of the domain wrap to the other side.
///
/// A lattice is cubic (2D: square), centred in the shape, and fitted to periodic axes that the shape spans. With `jittered`, each point of
/// the lattice is moved by up to a fifth of the spacing along each axis. Blue noise is irregular: no pair is closer than about 0.7
/// spacings, and the outermost particles are about half a spacing inside the surface.
/// @param beyond lattice: also include points up to this distance outside the shape [m]
/// @return empty if the shape contains no particle
std::vector<Vec3> sample_shape(const Shape& shape, Sampling sampling, Real spacing, const Domain& domain, std::uint64_t seed,
                               Layers layers = Layers::nearest, Real beyond = 0);

/// Relaxes points towards blue noise. Each point is pushed away from neighbours nearer than 1.6 spacings, and from mirror images of points
/// behind the surface, so that the density is even up to the surface.
/// @param domain only its periodic axes are used @param fixed neighbours that do not move @param obstacle distance [m] to a region that no
/// point approaches to less than least_clearance spacings; points in `fixed` must represent the inside of that region
void relax(std::vector<Vec3>& x, const Distance& distance, Real spacing, const Domain& domain, int sweeps,
           const std::vector<Vec3>& fixed = {}, const Distance& obstacle = {});

}  // namespace whorl
