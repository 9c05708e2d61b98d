#include "engine/particles/aggregates.h"

#include <catch2/catch.hpp>

using namespace whorl;

TEST_CASE("aggregates whose members are not connected by neighbours are split into connected pieces", "[particles]") {
    const std::vector<std::vector<Index>> near{{1}, {}, {3}, {2, 4}, {}, {6}, {}};
    std::vector<std::int32_t> group{1, 1, 1, 1, 2, 0, 0};
    const auto neighbours = [&](Index i, const auto& visit) {
        for (const Index j : near[i]) visit(j);
    };
    CHECK(split_unconnected(neighbours, group) == 3);
    CHECK(group == std::vector<std::int32_t>{1, 1, 2, 2, 3, 0, 0});
}
