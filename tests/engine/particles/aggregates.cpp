#include "engine/particles/aggregates.h"

#include <catch2/catch.hpp>

using namespace whorl;

TEST_CASE("aggregates whose members are not connected by neighbours are split into connected pieces, with their centres", "[particles]") {
    const std::vector<std::vector<Index>> near{{1}, {}, {3}, {2, 4}, {}, {6}, {}};
    std::vector<std::int32_t> group{1, 1, 1, 1, 2, 0, 0};
    const auto neighbours = [&](Index i, const auto& visit) {
        for (const Index j : near[i]) visit(j);
    };
    CHECK(split_unconnected(neighbours, group) == 3);
    CHECK(group == std::vector<std::int32_t>{1, 1, 2, 2, 3, 0, 0});
    // The first piece lies across the periodic boundary.
    const std::vector<Vec3> x{{0.9f, 0, 0}, {0.1f, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}, {5, 5, 5}, {5, 5, 5}};
    const std::vector<Vec3d> centre = aggregate_centres(x, group, 3, Domain{.periodic = {true, false, false}});
    CHECK((centre[0] - Vec3d(1, 0, 0)).norm() < 1e-6);
    CHECK(centre[1] == Vec3d(0, 0.5, 0.5));
    CHECK(centre[2] == Vec3d(1, 1, 1));
}
