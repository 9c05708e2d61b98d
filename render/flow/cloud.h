#pragma once
/// A field of the flow as a lit cloud, for drawing volumes.
#include <array>
#include <limits>
#include <vector>

#include "render/flow/flow_grid.h"

namespace whorl {

/// Light on a cloud, linear RGB.
struct CloudLight {
    Vec3f towards = Vec3f::UnitY();      ///< direction to the lamp, unit vector
    Vec3f lamp = Vec3f::Ones();          ///< radiance of an unshaded white body in the light of the lamp
    Vec3f sky = Vec3f::Zero();           ///< radiance of an unshaded white body in the ambient light
    Vec3f rim_towards = Vec3f::UnitY();  ///< direction to the rim light, unit vector
    Vec3f rim = Vec3f::Zero();           ///< radiance of an unshaded white body in the rim light
    float glow = 0;                      ///< emitted radiance over the colour of the cloud
};

/// Lit cloud on the nodes of a grid. A density of 1 is that of the strongest field.
struct Cloud {
    static constexpr int block = 4;      ///< nodes along a block's edge
    std::vector<Eigen::Vector4f> lit;    ///< per node: radiance times density (linear RGB), density
    std::array<int, 3> blocks{0, 0, 0};  ///< ceil(nodes / block) along each axis
    std::vector<float> most;             ///< largest density in a block, with one more node on each side; -n: empty, as are all blocks
                                         ///< less than n blocks away along every axis
};

/// Density per node: the cover times the square of the strength. @param grid with the strength as the fourth of its values
std::vector<float> cloud_density(const FlowGrid& grid);

/// Lights the cloud of density cloud_density(). Densities below 0.002 become 0.
/// @param grid with colour times strength (linear RGB) and strength as its values
/// @param thickness optical depth per metre at density 1
Cloud lit_cloud(const FlowGrid& grid, float thickness, const CloudLight& light);

/// Nodes from `low` to `high` along each axis; by default all nodes of a grid.
struct NodeBox {
    static constexpr int most = std::numeric_limits<int>::max();
    std::array<int, 3> low{0, 0, 0}, high{most, most, most};
};

/// Optical depth between each node and a distant lamp, within the grid. It is summed from layer to layer of nodes, and interpolated
/// linearly within a layer.
/// @param density per node @param thickness optical depth per metre at density 1 @param towards direction to the lamp, unit vector
/// @param box contains all nodes with a density; the depth is 0 outside of it
std::vector<float> depth_towards(const FlowGrid& grid, const std::vector<float>& density, float thickness, const Vec3f& towards,
                                 const NodeBox& box = {});

}  // namespace whorl
