#pragma once
/// The flow on a grid, from the particles of a frame, for drawing volumes and trails.
#include <array>
#include <cstdint>
#include <vector>

#include "engine/core/grid_index.h"
#include "engine/io/frame.h"

namespace whorl {

/// Node (i, j, k) is at origin + cell (i, j, k), i runs fastest. A periodic axis ends one cell before its first node
/// comes again.
struct FlowGrid {
    Vec3f origin = Vec3f::Zero();  ///< m
    Vec3f cell = Vec3f::Ones();    ///< m
    std::array<int, 3> n{0, 0, 0};
    std::array<bool, 3> periodic{false, false, false};
    std::vector<Vec3f> along;  ///< field that lines follow: velocity [m/s] or vorticity [1/s]; 0 where there is no fluid; may be left out
    std::vector<Eigen::Vector4f> value;  ///< of the shown field
    std::vector<float> cover;            ///< 0 no fluid near .. 1 full of it

    std::size_t index(int i, int j, int k) const { return grid_index(i, j, k, n[0], n[1]); }
    bool empty() const { return cover.empty(); }
    Vec3f extent() const { return cell.cwiseProduct(Vec3f(static_cast<float>(n[0]), static_cast<float>(n[1]), static_cast<float>(n[2]))); }

    struct Sample {
        Vec3f along = Vec3f::Zero();
        Eigen::Vector4f value = Eigen::Vector4f::Zero();
        float cover = 0;
    };
    /// Linear between the nodes; no cover outside.
    Sample at(const Vec3f& x) const;

    /// The eight nodes round a place and their weights; -1 where there is none.
    struct Corners {
        std::array<std::int64_t, 8> node;
        std::array<float, 8> weight;
    };
    Corners corners(const Vec3f& x) const;
};

/// Means over the particles within `reach` spacings of each node, weighted (1 - r^2/h^2)^2. Nodes are about `cell_in_spacings` spacings
/// apart, or further where the grid would have more than `most_nodes`. The same bits for any number of threads.
/// @param along of each particle: its velocity or vorticity; none: the grid has none either
/// @param value of each particle, up to four numbers; none: the grid has none either
FlowGrid flow_grid(const Frame& frame, const std::vector<Vec3f>& along, const std::vector<Eigen::Vector4f>& value,
                   std::size_t most_nodes = 8'000'000, float cell_in_spacings = 1, float reach = 1.5f);

}  // namespace whorl
