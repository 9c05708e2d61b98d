// Layout of a block: rows of similar length share a slice.
#include <algorithm>
#include <numeric>

#include "engine/models/viscosity/coupled/row_builder.h"

namespace whorl {

/// Puts rows of similar length into the same slices.
void CoupledRows::Scratch::arrange(RowBlock& block) const {
    const Index rows = block.size();
    block.count.resize(rows), block.lane.resize(rows);
    for (Index row = 0; row < rows; ++row) block.count[row] = static_cast<std::uint16_t>(row_first[row + 1] - row_first[row]);
    std::vector<Index> by_length(rows);
    std::iota(by_length.begin(), by_length.end(), 0);
    std::stable_sort(by_length.begin(), by_length.end(), [&](Index a, Index b) { return block.count[a] > block.count[b]; });
    block.slices.assign(static_cast<std::size_t>((rows + lane_count - 1) / lane_count), RowSlice());
    block.wall_weight.clear();
    std::vector<Index> wall_count(rows, 0);
    for (const WallPoint& wall : block.walls) ++wall_count[wall.row];
    std::size_t end = 0;
    for (std::size_t k = 0; k < block.slices.size(); ++k) {
        RowSlice& slice = block.slices[k];
        slice.begin = end;
        slice.first_wall = block.wall_weight.size();
        for (Index lane = 0; lane < std::min<Index>(lane_count, rows - static_cast<Index>(k) * lane_count); ++lane)
            slice.walls = std::max(slice.walls, wall_count[by_length[k * lane_count + static_cast<std::size_t>(lane)]]);
        slice.width = block.count[by_length[k * lane_count]] + slice.walls;
        block.wall_weight.resize(slice.first_wall + static_cast<std::size_t>(slice.walls), Lanes{});
        end += static_cast<std::size_t>(slice.width) * lane_count;
    }
    block.other.resize(end);
    for (std::size_t k = 0; k < block.slices.size(); ++k) {
        RowSlice& slice = block.slices[k];
        slice.rows = std::min<Index>(lane_count, rows - static_cast<Index>(k) * lane_count);
        for (Index lane = 0; lane < lane_count; ++lane) {
            const Index row = by_length[k * lane_count + static_cast<std::size_t>(lane < slice.rows ? lane : 0)];
            const Index count = lane < slice.rows ? block.count[row] : 0;
            slice.row[lane] = static_cast<std::uint16_t>(row);
            slice.of_h2[lane] = 1 / (row_h[row] * row_h[row]);
            std::size_t to = slice.begin + static_cast<std::size_t>(lane), from = row_first[row];
            if (lane < slice.rows) block.lane[row] = static_cast<std::uint16_t>(k * lane_count + static_cast<std::size_t>(lane));
            for (Index e = 0; e < count; ++e, ++from, to += lane_count) block.other[to] = row_other[from];
            for (Index e = count; e < slice.width; ++e, to += lane_count) block.other[to] = static_cast<RowBlock::LocalIndex>(row);
        }
    }
    for (std::size_t k = 0, of_row = 0; k < block.walls.size(); ++k) {
        const Index row = block.walls[k].row;
        of_row = k > 0 && block.walls[k - 1].row == row ? of_row + 1 : 0;
        const RowSlice& slice = block.slice_of(row);
        const Index lane = block.lane_in_slice(row);
        block.wall_weight[slice.first_wall + of_row][lane] = block.walls[k].weight;
        block.other[slice.begin + (static_cast<std::size_t>(slice.plain()) + of_row) * lane_count + static_cast<std::size_t>(lane)] =
            static_cast<RowBlock::LocalIndex>(block.touched.size() + k);
    }
}

}  // namespace whorl
