#include <catch2/catch.hpp>
#include <set>

#include "render/surface/marching_cubes.h"

using namespace whorl;

TEST_CASE("every pattern of corners cuts each edge of mixed signs once, in closed loops", "[surface]") {
    for (unsigned inside = 0; inside < 256; ++inside) {
        std::multiset<int> cut;
        for (const CubeLoop& loop : cube_case(inside).loops) {
            REQUIRE(loop.edge.size() >= 3);
            cut.insert(loop.edge.begin(), loop.edge.end());
        }
        for (int e = 0; e < 12; ++e) {
            const auto [corner, axis] = cube_edges()[e];
            const bool mixed = (inside >> corner & 1) != (inside >> (corner + (1 << axis)) & 1);
            REQUIRE(cut.count(e) == (mixed ? 1 : 0));
        }
    }
}
