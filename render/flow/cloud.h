#pragma once
/// The flow as a lit cloud, for drawing volumes.
#include <array>
#include <vector>

#include "render/flow/flow_grid.h"

namespace whorl {

/// The light that falls on a cloud, linear RGB.
struct CloudLight {
    Vec3f towards = Vec3f::UnitY();  ///< the lamp, unit length
    Vec3f lamp = Vec3f::Ones();      ///< its light on an unshaded white body
    Vec3f sky = Vec3f::Zero();       ///< the same of the light from all round
    float glow = 0;                  ///< the cloud's emission, in its colour
};

/// On the nodes of a grid. Densities are parts of the strongest field's.
struct Cloud {
    static constexpr int block = 8;      ///< nodes along a block's edge
    std::vector<Eigen::Vector4f> lit;    ///< radiance times density, density
    std::array<int, 3> blocks{0, 0, 0};  ///< ceil(nodes / block) along each axis
    std::vector<float> most;             ///< largest density in a block and a node around it; 0: empty
};

/// The square of the strength, as far as there is fluid. @param grid with the strength as the fourth of its values
std::vector<float> cloud_density(const FlowGrid& grid);

/// @param grid with colour times strength, and strength, as its values; the density is cloud_density()
/// @param thickness optical depth of a metre of density 1
Cloud lit_cloud(const FlowGrid& grid, float thickness, const CloudLight& light);

/// Optical depth between each node and a lamp far off in the direction `towards`, over the grid alone: linear from layer to layer of nodes.
/// @param density of each node @param thickness optical depth of a metre of density 1
std::vector<float> depth_towards(const FlowGrid& grid, const std::vector<float>& density, float thickness, const Vec3f& towards);

}  // namespace whorl
