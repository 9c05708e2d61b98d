#pragma once
/// Fields of the flow on a grid, averaged from the particles of a frame, for drawing volumes, vortex lines and trails.
#include <array>
#include <cstddef>
#include <vector>

#include "engine/core/grid_index.h"
#include "engine/io/frame.h"

namespace whorl {

/// Fields on nodes. Node (i, j, k) is at origin + cell (i, j, k); i runs fastest. A periodic axis has no node at its end, because the first
/// node represents it.
struct FlowGrid {
    Vec3f origin = Vec3f::Zero();  ///< m
    Vec3f cell = Vec3f::Ones();    ///< m
    std::array<int, 3> n{0, 0, 0};
    std::array<bool, 3> periodic{false, false, false};
    std::vector<Vec3f> along;            ///< field that lines follow: velocity [m/s] or vorticity [1/s]; 0 without fluid; may be empty
    std::vector<Eigen::Vector4f> value;  ///< up to four numbers of the shown field; 0 without fluid; may be empty
    std::vector<float> cover;            ///< 0 no fluid nearby .. 1 full of fluid

    std::size_t index(int i, int j, int k) const { return grid_index(i, j, k, n[0], n[1]); }
    bool empty() const { return cover.empty(); }
    Vec3f extent() const { return cell.cwiseProduct(Vec3f(static_cast<float>(n[0]), static_cast<float>(n[1]), static_cast<float>(n[2]))); }

    struct Sample {
        Vec3f along = Vec3f::Zero();
        Eigen::Vector4f value = Eigen::Vector4f::Zero();
        float cover = 0;
    };
    /// Linear interpolation; `along` and `value` use only nodes with fluid. Outside the grid the cover is 0.
    Sample at(const Vec3f& x) const;

    /// The eight nodes around a point and their weights in a linear interpolation. A node outside the grid is replaced by node 0 with
    /// weight 0.
    struct Corners {
        std::array<std::size_t, 8> node;
        std::array<float, 8> weight;
    };
    Corners corners(const Vec3f& x) const;
};

/// Means over the particles within h of each node, weighted by (1 - r^2/h^2)^2; h is `reach` spacings, and at least 1.2 cells. Nodes are
/// about `cell_in_spacings` spacings apart, or further if the grid would have more than `most_nodes`. Without `along`, the cover may be 0
/// or too small where `value` is 0. Bit-identical for any number of threads.
/// @param along velocity [m/s] or vorticity [1/s] per particle; empty: FlowGrid::along is empty
/// @param value up to four numbers per particle; empty: FlowGrid::value is empty
FlowGrid flow_grid(const Frame& frame, const std::vector<Vec3f>& along, const std::vector<Eigen::Vector4f>& value,
                   std::size_t most_nodes = 8'000'000, float cell_in_spacings = 1, float reach = 1.5f);

}  // namespace whorl
