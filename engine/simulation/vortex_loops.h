#pragma once
/// Closed vortex lines that the fluid has at the start.
#include <vector>

#include "engine/scene/scene.h"
#include "engine/simulation/world.h"

namespace whorl {

/// u(x) = Gamma/(4 pi) sum over segments of ds x (x - s)/(|x - s|^2 + a^2)^(3/2), a the core
///
/// The law of Biot and Savart with the core of Rosenhead (1930) and Moore (1972): a straight line has the vorticity
/// Gamma a^2/(pi (r^2 + a^2)^2). Along a periodic axis each line exists three times, at its place and a period to either side.
class VortexLoop {
public:
    VortexLoop(const VortexKeys& keys, const Domain& domain);
    struct Nearest {
        double distance;  ///< m
        double t;         ///< of the path
    };
    Vec3d velocity(const Vec3d& x) const;  ///< m/s
    /// The line's nearest point, where one is nearer than `reach` [m]; else at an infinite distance.
    Nearest nearest(const Vec3d& x, double reach) const;

private:
    std::size_t segments_;                      ///< of one image; a quarter of the core long
    double strength_, core_, longest_ = 0;      ///< longest_: m, of the segments
    std::vector<double> middle_[3], along_[3];  ///< m, of each segment of each image
};

/// Adds the velocity of the scene's vortices to the fluid, and their inks.
void add_vortices(const Scene& scene, World& world);

}  // namespace whorl
