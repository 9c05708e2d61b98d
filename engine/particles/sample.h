#pragma once
/// Fills shapes with particles.
#include <functional>
#include <vector>

#include "engine/core/random.h"
#include "engine/geometry/domain.h"
#include "engine/geometry/shape.h"

namespace whorl {

/// In spacings: no particle is placed closer than this to a solid or a pipe.
inline constexpr double least_clearance = 0.45;

enum class Sampling { lattice, jittered, blue_noise };
/// Number of a lattice's layers along an axis: nearest to the shape's length, or as many as fit half a spacing within it
/// (least_clearance).
enum class Layers { nearest, within };

/// Signed distance [m], negative inside.
using Distance = std::function<Real(const Vec3&)>;

/// Positions that fill the shape, one a volume spacing^3, in a domain without depth spacing^2; the same for the same seed.
/// lattice: cubic (square), centred in the shape, fitted to periodic axes that the shape spans. jittered: the lattice, each point moved by
/// up to a fifth of the spacing. blue_noise: irregular, no pair closer than about 0.7 spacings, the outermost particles about half a
/// spacing inside the surface. What lies beyond a periodic face of the domain comes in again on the other side.
/// @param beyond lattice: also points up to this far outside of the shape [m]
/// @return empty if the shape holds no particle
std::vector<Vec3> sample_shape(const Shape& shape, Sampling sampling, Real spacing, const Domain& domain, std::uint64_t seed,
                               Layers layers = Layers::nearest, Real beyond = 0);

/// Relaxes points towards blue noise: each is pushed away from neighbours nearer than 1.6 spacings, and from their mirror images behind the
/// surface, so that the density stays even up to it.
/// @param domain only its periodic axes are used @param fixed neighbours that stay where they are @param obstacle distance [m] from what
/// no point comes nearer to than least_clearance spacings; `fixed` represents its inside
void relax(std::vector<Vec3>& x, const Distance& distance, Real spacing, const Domain& domain, int sweeps,
           const std::vector<Vec3>& fixed = {}, const Distance& obstacle = {});

}  // namespace whorl
