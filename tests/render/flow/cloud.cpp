// Light in a cloud.
#include "render/flow/cloud.h"

#include <catch2/catch.hpp>
#include <cmath>

using namespace whorl;

namespace {

/// A cube of 1 m, with white density 1 where `dense` is true.
template <class F>
FlowGrid white_cube(int nodes, F&& dense) {
    FlowGrid grid;
    grid.n = {nodes, nodes, nodes};
    grid.cell = Vec3f::Constant(1 / static_cast<float>(nodes));
    grid.origin = 0.5f * grid.cell;
    for (int k = 0; k < nodes; ++k)
        for (int j = 0; j < nodes; ++j)
            for (int i = 0; i < nodes; ++i) {
                grid.value.push_back(dense(i, j, k) ? Eigen::Vector4f::Ones() : Eigen::Vector4f::Zero());
                grid.cover.push_back(1);
            }
    grid.along.resize(grid.value.size());
    return grid;
}

}  // namespace

TEST_CASE("light decays in an even cloud with its depth, from above and slanting", "[render][flow]") {
    const int n = 32;
    const FlowGrid grid = white_cube(n, [](int, int, int) { return true; });
    const std::vector<float> density(grid.value.size(), 1);
    const float thickness = 3;
    for (const Vec3f& lamp : {Vec3f(0, 1, 0), Vec3f(Vec3f(0.3f, 0.9f, -0.2f).normalized())}) {
        const std::vector<float> depth = depth_towards(grid, density, thickness, lamp);
        for (const int j : {0, 9, 20, 31}) {
            // Along the light up to the outermost nodes, far from the sides, where its path is shorter.
            const float way = static_cast<float>(n - 1 - j) * grid.cell.y() / lamp.y();
            CHECK(depth[grid.index(8, j, 22)] == Approx(thickness * way).margin(1e-4));
        }
    }
}

TEST_CASE("an object in a cloud's light casts a shadow, and empty blocks know their distance to it", "[render][flow]") {
    const FlowGrid grid = white_cube(24, [](int i, int j, int k) { return i >= 10 && i < 14 && k >= 10 && k < 14 && (j == 20 || j == 4); });
    CloudLight light;
    light.lamp = Vec3f(1, 1, 1), light.sky = Vec3f::Zero();
    const Cloud cloud = lit_cloud(grid, 200, light);
    const Eigen::Vector4f upper = cloud.lit[grid.index(12, 20, 12)], lower = cloud.lit[grid.index(12, 4, 12)];
    // The upper plate's own half cell of depth 200/24/2 above it has no fluid; the lower one sees a whole cell of depth 8.3 in its way.
    CHECK(upper[0] == Approx(std::exp(-200.0f / 24 / 2)).epsilon(1e-3));
    CHECK(lower[0] == Approx(upper[0] * std::exp(-200.0f / 24)).epsilon(1e-2));
    CHECK(upper[3] == 1);
    // The rim light comes from below: the plates swap.
    light.lamp = Vec3f::Zero(), light.rim = Vec3f(1, 1, 1), light.rim_towards = -Vec3f::UnitY();
    const Cloud rimmed = lit_cloud(grid, 200, light);
    CHECK(rimmed.lit[grid.index(12, 4, 12)][0] == Approx(upper[0]).epsilon(1e-3));
    CHECK(rimmed.lit[grid.index(12, 20, 12)][0] == Approx(lower[0]).epsilon(1e-2));
    CHECK(cloud.blocks == std::array<int, 3>{6, 6, 6});
    const auto most = [&](int i, int j, int k) { return cloud.most[(k * 6 + j) * 6 + i]; };
    CHECK(most(3, 5, 3) == 1);   // with the upper plate
    CHECK(most(0, 0, 0) == -2);  // two blocks from the lower plate, whose blocks are 2 and 3
    CHECK(most(5, 3, 0) == -2);
    CHECK(most(3, 3, 3) == -1);
}
