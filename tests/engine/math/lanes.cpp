#include "engine/math/lanes.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "engine/core/column.h"

using namespace whorl;

namespace lanes_test {

TEST_CASE("vectors gather into lanes and scatter back, also to shared positions", "[math]") {
    constexpr Index pieces = 3 * lane_count;
    Column<Vec4> from(pieces), to(2 * pieces, Vec4{});
    for (Index i = 0; i < pieces; ++i) from[i] = {{Real(i), Real(100 + i), Real(200 + i), Real(300 + i)}};
    Index place[lane_count];
    for (Index lane = 0; lane < lane_count; ++lane)
        place[lane] = (5 * lane + 1) % (lane_count / 2);  // Each index occurs twice, sometimes within one group of four.
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

TEST_CASE("gathering pieces in pairs equals one gather after the other", "[math]") {
    constexpr Index pieces = 3 * lane_count;
    Column<Vec4> from(2 * pieces);
    for (std::size_t i = 0; i < from.size(); ++i) from[i] = {{Real(i), Real(100 + i), Real(200 + i), -1}};
    std::uint16_t place[lane_count];
    for (Index lane = 0; lane < lane_count; ++lane) place[lane] = static_cast<std::uint16_t>((7 * lane + 2) % pieces);
    const TwoLanes3 both = gather_two(from.data(), place);
    const Lanes3 second = gather<2>(from.data() + 1, place);
    for (Index lane = 0; lane < lane_count; ++lane) {
        const Real i = static_cast<Real>(2 * place[lane]);
        CHECK((both.first.x[lane] == i && both.first.y[lane] == 100 + i && both.first.z[lane] == 200 + i));
        CHECK((both.second.x[lane] == i + 1 && both.second.y[lane] == 101 + i && both.second.z[lane] == 201 + i));
        CHECK((second.x[lane] == i + 1 && second.y[lane] == 101 + i && second.z[lane] == 201 + i));
    }
    const Vec4 v = with_spare(Vec3(1, 2, 3));
    CHECK((v.v[0] == 1 && v.v[1] == 2 && v.v[2] == 3 && v.v[3] == 0));
}

// Small whole numbers: all sums and products are exact, in any order.
TEST_CASE("arithmetic in lanes equals that of vectors and matrices, lane by lane", "[math]") {
    const auto number = [](Index lane, int k) { return static_cast<Real>((7 * lane + 5 * k + 3 * lane * k) % 23 - 11); };
    Mat3 A[lane_count], S[lane_count];
    Vec3 u[lane_count], v[lane_count];
    Lanes a;
    Lanes33 A_lanes;
    SymmetricLanes S_lanes;
    Lanes3 u_lanes, v_lanes;
    for (Index lane = 0; lane < lane_count; ++lane) {
        for (int k = 0; k < 9; ++k) A[lane](k / 3, k % 3) = number(lane, k);
        for (int k = 0; k < 3; ++k) u[lane][k] = number(lane, 10 + k), v[lane][k] = number(lane, 20 + k);
        S[lane] = A[lane] + A[lane].transpose();
        a[lane] = number(lane, 30);
        set_lane(A_lanes, lane, A[lane]), set_lane(S_lanes, lane, S[lane]);
        u_lanes.x[lane] = u[lane][0], u_lanes.y[lane] = u[lane][1], u_lanes.z[lane] = u[lane][2];
        v_lanes.x[lane] = v[lane][0], v_lanes.y[lane] = v[lane][1], v_lanes.z[lane] = v[lane][2];
    }
    const auto vector = [](const Lanes3& of, Index lane) { return Vec3(of.x[lane], of.y[lane], of.z[lane]); };
    const Lanes product = dot(u_lanes, v_lanes), least = at_least(a, 2), most = at_most(a, 2), root = square_root(a * a),
                rounds = rounded(a * Real(0.3)), same = lanes_of(Real(7));
    for (Index lane = 0; lane < lane_count; ++lane) {
        CHECK(lane_of(A_lanes, lane) == A[lane]);
        CHECK(lane_of(S_lanes, lane) == S[lane]);
        CHECK(lane_of(whole(S_lanes), lane) == S[lane]);
        CHECK(lane_of(lanes_of(S[0]), lane) == S[0]);
        CHECK(lane_of(symmetric(A_lanes), lane) == Mat3(Real(0.5) * S[lane]));
        CHECK(vector(u_lanes + v_lanes, lane) == u[lane] + v[lane]);
        CHECK(vector(u_lanes - v_lanes, lane) == u[lane] - v[lane]);
        CHECK(vector(a * u_lanes, lane) == a[lane] * u[lane]);
        CHECK(vector(S_lanes * u_lanes, lane) == S[lane] * u[lane]);
        CHECK(vector(A_lanes * u_lanes, lane) == A[lane] * u[lane]);
        CHECK(lane_of(A_lanes * S_lanes, lane) == Mat3(A[lane] * S[lane]));
        CHECK(lane_of(S_lanes * A_lanes, lane) == Mat3(S[lane] * A[lane]));
        CHECK(product[lane] == u[lane].dot(v[lane]));
        CHECK(least[lane] == std::max(a[lane], Real(2)));
        CHECK(most[lane] == std::min(a[lane], Real(2)));
        CHECK(root[lane] == std::abs(a[lane]));
        CHECK(rounds[lane] == std::nearbyint(a[lane] * Real(0.3)));
        CHECK(same[lane] == 7);
    }
    CHECK(any_above(a, a[lane_count - 1] - 1));
    CHECK_FALSE(any_above(a, 11));

    // Symmetric matrices, scattered to repeated positions.
    Index place[lane_count];
    std::vector<Mat3> expected(3, Mat3::Zero());
    for (Index lane = 0; lane < lane_count; ++lane) place[lane] = lane % 3, expected[lane % 3] += S[lane];
    Column<Vec4> to(6, Vec4{});
    scatter(S_lanes, place, to.data());
    for (std::size_t k = 0; k < 3; ++k) {
        const Real *even = to[2 * k].v, *mixed = to[2 * k + 1].v;
        Mat3 sum;
        sum << even[0], mixed[0], mixed[1], mixed[0], even[1], mixed[2], mixed[1], mixed[2], even[2];
        CHECK(sum == expected[k]);
    }
}

}  // namespace lanes_test
