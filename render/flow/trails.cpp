#include "render/flow/trails.h"

#include <Eigen/Geometry>

#include "engine/core/parallel.h"

namespace whorl {
namespace {

constexpr int pieces = 6;

}  // namespace

Trails trails(const Frame& frame, const std::vector<Vec3f>& colour, const FlowGrid& grid, float seconds, float width, const Vec3f& eye) {
    constexpr std::size_t corners = 2 * (pieces + 1), indices = 6 * pieces;
    const std::size_t n = frame.position.size();
    Trails all;
    all.position.resize(corners * n);
    all.colour.resize(corners * n);
    all.index.resize(indices * n);
    const float step = seconds / pieces;
    parallel_for(static_cast<Index>(n), [&](Index p) {
        Vec3f way[pieces + 1];
        way[0] = frame.position[p];
        for (int k = 0; k < pieces; ++k) {
            const Vec3f first = k == 0 ? frame.velocity[p] : grid.at(way[k]).along;
            way[k + 1] = way[k] - step * grid.at(way[k] - 0.5f * step * first).along;
        }
        for (int k = 0; k <= pieces; ++k) {
            const Vec3f along = way[std::max(0, k - 1)] - way[std::min(pieces, k + 1)];
            Vec3f side = along.cross(way[k] - eye);
            const float length = side.norm();
            side = length > 0 ? Vec3f(side / length) : Vec3f(Vec3f::Zero());
            const float half = 0.5f * width * (1 - static_cast<float>(k) / pieces);
            const std::size_t corner = corners * p + 2 * k;
            all.position[corner] = way[k] + half * side, all.position[corner + 1] = way[k] - half * side;
            all.colour[corner] = all.colour[corner + 1] = colour[p];
        }
        for (int k = 0; k < pieces; ++k) {
            const auto c = static_cast<std::uint32_t>(corners * p + 2 * k);
            const std::uint32_t two[6] = {c, c + 1, c + 2, c + 2, c + 1, c + 3};
            std::copy(two, two + 6, all.index.begin() + indices * p + 6 * k);
        }
    });
    return all;
}

}  // namespace whorl
