#include "render/flow/slice.h"

#include <algorithm>
#include <cmath>

#include "engine/core/parallel.h"
#include "render/flow/streaks.h"
#include "render/look/colour_map.h"

namespace whorl {

namespace {
int axis_of(const LookOptions& look) { return look.slice_axis == "x" ? 0 : look.slice_axis == "y" ? 1 : 2; }
}  // namespace

float slice_position(const FlowGrid& grid, const LookOptions& look) {
    if (look.slice_position) return *look.slice_position;
    const int axis = axis_of(look);
    return grid.origin[axis] + 0.5f * grid.extent()[axis];
}

FlowSlice flow_slice(const FlowGrid& grid, const LookOptions& look, int longest) {
    FlowSlice slice;
    if (grid.empty()) return slice;
    const int axis = axis_of(look), a = axis == 0 ? 1 : 0, b = axis == 2 ? 1 : 2;
    const Vec3f size = grid.extent();
    slice.corner = grid.origin;
    slice.corner[axis] = slice_position(grid, look);
    slice.across[a] = size[a], slice.up[b] = size[b];
    const float pixel = std::max(size[a], size[b]) / static_cast<float>(longest);
    slice.width = std::max(2, static_cast<int>(std::lround(size[a] / pixel)));
    slice.height = std::max(2, static_cast<int>(std::lround(size[b] / pixel)));

    const std::size_t pixels = grid_count(slice.width, slice.height);
    std::vector<Eigen::Vector2f> velocity(pixels);
    std::vector<float> value(pixels);
    slice.rgba.resize(4 * pixels);
    parallel_blocks(slice.height, 4, [&](Index begin, Index end) {
        for (Index y = begin; y < end; ++y)
            for (int x = 0; x < slice.width; ++x) {
                const std::size_t k = grid_index(x, y, slice.width);
                const Vec3f place = slice.corner + (static_cast<float>(x) + 0.5f) / static_cast<float>(slice.width) * slice.across +
                                    (static_cast<float>(y) + 0.5f) / static_cast<float>(slice.height) * slice.up;
                const FlowGrid::Sample s = grid.at(place);
                velocity[k] = s.cover > 0 ? Eigen::Vector2f(s.velocity[a], s.velocity[b]) : Eigen::Vector2f::Zero();
                value[k] = s.value;
                slice.rgba[4 * k + 3] = s.cover;
            }
    });
    std::vector<float> bright;
    float fast = 0;
    if (look.streaks) {
        bright = streaks(velocity, slice.width, slice.height, std::max(6, longest / 45));
        for (const Eigen::Vector2f& v : velocity) fast = std::max(fast, v.norm());
    }
    parallel_for(static_cast<Index>(pixels), [&](Index k) {
        Vec3f colour = linear_of(map_colour(look.colour_map, value[k]));
        // Still water is calm: no noise where nothing moves.
        if (fast > 0) colour *= 1 + 1.1f * std::min(1.0f, 8 * velocity[k].norm() / fast) * (bright[k] - 0.5f);
        for (int c = 0; c < 3; ++c) slice.rgba[4 * k + c] = colour[c];
    });
    return slice;
}

}  // namespace whorl
