#pragma once
/// Rooms that fluid cannot leave, with emitters in them: more may come than fits.
#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "engine/core/types.h"

namespace whorl {

struct Scene;
struct SceneShapes;

/// The places that an emitter's fluid can reach from its opening: between solids, periodic axes and the pipes of emitters, with no way to a
/// drain or out of the domain, at the start.
struct ClosedRoom {
    Eigen::AlignedBox3d box;  ///< m, about it
    double volume = 0;        ///< m^3 that fluid can fill; in two dimensions m^2
    double fluid = 0;         ///< of that, within blocks at the start
    double coming = 0;        ///< until the end of the run
    std::vector<std::size_t> emitters;
    std::string text() const;   ///< "the closed room from (0, 0, 0) to (1, 1, 1) m"
    std::string names() const;  ///< "emitter[0] and emitter[1]"
};

/// Found on a lattice of half a spacing; a way that is narrower than a tenth of one is none. Nothing is claimed of a scene with solids that
/// move by expressions, nor of a domain with more than ten million places. @param support of the fluid's kernel [m]
std::vector<ClosedRoom> closed_rooms(const Scene& scene, const SceneShapes& shapes, double support);

}  // namespace whorl
