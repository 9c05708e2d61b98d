#pragma once
/// Closed vortex lines in the fluid at the start.
#include <Eigen/Geometry>
#include <vector>

#include "engine/scene/scene.h"
#include "engine/simulation/world.h"

namespace whorl {

/// Closed vortex line with the velocity u(x) = Gamma/(4 pi) sum over segments of ds cross (x - s)/(|x - s|^2 + a^2)^(3/2)
///
/// Gamma is the circulation, a the core radius, s the middle of a segment and ds the vector along it. This is the law of Biot and Savart
/// with the core of Rosenhead (1930) and Moore (1972). A straight line has the vorticity Gamma a^2/(pi (r^2 + a^2)^2) at the distance r.
/// Along a periodic axis each line has three images: the line itself, and one shifted by a period to either side.
class VortexLoop {
public:
    VortexLoop(const VortexKeys& keys, const Domain& domain);
    struct Nearest {
        double distance;  ///< m
        double t;         ///< parameter of the path
    };
    Vec3d velocity(const Vec3d& x) const;  ///< m/s
    /// The nearest point of the line; at an infinite distance if none is nearer than `reach` [m].
    Nearest nearest(const Vec3d& x, double reach) const;

private:
    std::size_t segments_;                      ///< number per image, 64 to 4096; if possible, each is a quarter of the core radius long
    double strength_, core_, longest_ = 0;      ///< longest_: longest segment [m]
    std::vector<Eigen::AlignedBox3d> boxes_;    ///< around the middles of the segments of each image
    std::vector<double> middle_[3], along_[3];  ///< by axis: middle and vector of each segment of each image [m]
};

/// Adds the velocity of the scene's vortices to the fluid, and their inks.
void add_vortices(const Scene& scene, World& world);

}  // namespace whorl
