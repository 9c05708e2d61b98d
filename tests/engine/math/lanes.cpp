#include "engine/math/lanes.h"

#include <catch2/catch.hpp>

#include "engine/core/column.h"

using namespace whorl;

namespace lanes_test {

TEST_CASE("vectors go into lanes and back to their places, those that share a place too", "[math]") {
    constexpr Index pieces = 3 * lane_count;
    Column<Vec4> from(pieces), to(2 * pieces, Vec4{});
    for (Index i = 0; i < pieces; ++i) from[i] = {{Real(i), Real(100 + i), Real(200 + i), Real(300 + i)}};
    Index place[lane_count];
    for (Index lane = 0; lane < lane_count; ++lane) place[lane] = (5 * lane + 1) % (lane_count / 2);  // each twice, some within one four
    Lanes fourth;
    const Lanes3 v = gather(from.data(), place, &fourth);
    for (Index lane = 0; lane < lane_count; ++lane) {
        const Real i = static_cast<Real>(place[lane]);
        CHECK((v.x[lane] == i && v.y[lane] == 100 + i && v.z[lane] == 200 + i && fourth[lane] == 300 + i));
    }
    scatter<2>(v, place, to.data() + 1);
    std::vector<Vec4> expected(to.size(), Vec4{});
    for (Index lane = 0; lane < lane_count; ++lane)
        for (int a = 0; a < 3; ++a) expected[2 * place[lane] + 1].v[a] += from[place[lane]].v[a];
    for (std::size_t i = 0; i < to.size(); ++i)
        for (int a = 0; a < 4; ++a) CHECK(to[i].v[a] == expected[i].v[a]);  // small whole numbers: exact
}

}  // namespace lanes_test
