/// Honey in a tank whose walls it slides along, solved by the coupled model.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "engine/geometry/shape.h"
#include "tests/support/coupled_world.h"

using namespace whorl;
using namespace whorl::test;

namespace {

/// Fluid in a box whose walls it slides along, W x H x 6 particles in the left of a tank L particles long.
struct Tank : CoupledWorld {
    static constexpr double d = 0.01;
    static std::vector<Vec3> column(int W, int H) {
        std::vector<Vec3> x;
        for (int a = 0; a < W; ++a)
            for (int b = 0; b < H; ++b)
                for (int c = 0; c < 6; ++c)
                    x.push_back((d * Vec3d(a + 0.5 + 0.02 * std::sin(7 * a + 3 * b + c), b + 0.5, c + 0.5)).cast<Real>());
        return x;
    }
    Tank(int W, int H, int L, double nu) : CoupledWorld(column(W, H), Real(d), Real(nu)) {
        world.step.domain = Domain{Vec3(-1, -1, -1), Vec3(1, 2, 1), {false, false, false}};
        world.step.gravity = Vec3(0, Real(-9.81), 0);
        Solid tank;
        tank.shape = make_box(Vec3d::Zero(), d * Vec3d(L, 100, 6));
        tank.slip_length = std::numeric_limits<double>::infinity();
        tank.inside = true;
        world.solids.all.push_back(tank);
    }
    void run_until(double end) {
        while (time < end) {
            double fastest = 0.05;
            for (const Vec3& u : velocity()) fastest = std::max<double>(fastest, u.norm());
            REQUIRE(step(Real(std::min({0.4 * d / fastest, std::sqrt(0.8 * d / 9.81), 0.01}))));
        }
    }
    /// Mean over the particles.
    template <class F>
    double mean(const F& f) {
        double sum = 0;
        for (std::size_t i = 0; i < position().size(); ++i) sum += f(i);
        return sum / static_cast<double>(position().size());
    }
};

}  // namespace

TEST_CASE("coupled: a collapsing column of honey stays in one piece and less than twice as wide for 0.3 s", "[validation][coupled]") {
    Tank honey(15, 20, 40, 1);
    honey.run_until(0.3);
    double front = 0;
    std::vector<Vec3d> points;
    for (const Vec3& x : honey.position()) front = std::max<double>(front, x[0]), points.push_back(x.cast<double>());
    CHECK(front < 0.3);
    CHECK(longest_link(points) < 1.6 * Tank::d);
}

TEST_CASE("coupled: a pool of honey 5 particles deep comes to rest and keeps its height within 4 %", "[validation][coupled][regression]") {
    // 2 to 3.2 % are lost over 1.2 to 2 s: the density limit (n/n0 <= 1) counts fluid particles but not walls. The lattice melts, and the
    // least-squares divergence does not detect every layer that falls into another.
    Tank pool(12, 5, 12, 1);
    pool.run_until(1.2);
    CHECK(std::sqrt(pool.mean([&](std::size_t i) { return double(pool.velocity()[i].squaredNorm()); })) < 0.02);
    CHECK(pool.mean([&](std::size_t i) { return double(pool.position()[i][1]); }) == Approx(0.5 * 5 * Tank::d).epsilon(0.04));
}
