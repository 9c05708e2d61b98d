/// Water with a free surface against an experiment and against linear wave theory.
#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "engine/scene/read.h"
#include "engine/sim/simulation.h"
#include "tests/support/zeros.h"

using namespace whorl;

namespace waves_test {

namespace {

constexpr double g = 9.81;

}  // namespace

TEST_CASE("the front of a collapsing column, 40 particles high, is within 5 % of the experiment's at every time of its table",
          "[validation][sim]") {
    // Martin and Moyce 1952, table 2: a column of width a = 2.25 in and height 2 a; Z = x/a at T = t sqrt(2 g/a). There a membrane has to
    // burst before the water moves, and when it had is known no better than that: times count from the table's first row, Z = 1.22, which
    // the water that is free at once reaches 0.15 in T earlier. 3.5 % were measured; in T as printed the front leads by 6 to 14 %. Its mean
    // speed is within 5 %, too.
    constexpr double a = 0.05715;
    const std::vector<std::pair<double, double>> measured{{0.84, 1.22}, {1.19, 1.44}, {1.43, 1.67}, {1.63, 1.89}, {1.83, 2.11},
                                                          {1.98, 2.33}, {2.20, 2.56}, {2.32, 2.78}, {2.51, 3.00}, {2.65, 3.22},
                                                          {2.83, 3.44}, {2.98, 3.67}, {3.11, 3.89}};
    const double d = a / 20;
    const Scene scene = read_scene_text(fmt::format(R"toml([time]
end = 1
max_step = 5e-3
[domain]
min = [{0}, {0}, 0]
max = [{1}, {2}, {3}]
periodic = [false, false, true]
[fluid]
spacing = {4}
[models]
pressure = "ppe"
[[block]]
shape = "box"
min = [0, 0, 0]
max = [{5}, {6}, {3}]
[[solid]]
shape = "plane"
[[solid]]
shape = "plane"
normal = [1, 0, 0]
)toml",
                                                    -3 * d, 6 * a, 3 * a, 6 * d, d, a, 2 * a),
                                        "column.toml");
    Simulation simulation(scene, make_plan(scene));
    const double second = std::sqrt(2 * g / a);
    std::vector<std::pair<double, double>> run{{0, 1}};
    while (run.back().second < measured.back().second && run.back().first < 4) {
        REQUIRE_FALSE(simulation.step(1).diverged);
        std::vector<Real> x;
        for (const Vec3& one : simulation.world().fluid.column<field::position>()) x.push_back(one.x());
        // Two rows of six particles may be drops ahead of the front.
        std::nth_element(x.begin(), x.end() - 13, x.end());
        run.emplace_back(simulation.time() * second, (x[x.size() - 13] + d / 2) / a);
    }
    const auto between = [&](double value, auto from, auto to) {
        std::size_t k = 1;
        while (k + 1 < run.size() && run[k].*from < value) ++k;
        const double part = (value - run[k - 1].*from) / (run[k].*from - run[k - 1].*from);
        return run[k - 1].*to + part * (run[k].*to - run[k - 1].*to);
    };
    using Row = std::pair<double, double>;
    const double earlier = measured[0].first - between(measured[0].second, &Row::second, &Row::first);
    CHECK(earlier > 0);
    CHECK(earlier < 0.25);
    for (const auto& [T, Z] : measured) {
        const double front = between(T - earlier, &Row::first, &Row::second);
        INFO("T = " << T << ": " << front << ", measured " << Z);
        CHECK(front == Approx(Z).epsilon(0.05));
    }
    const double speed = (measured.back().second - measured[2].second) / (measured.back().first - measured[2].first);
    const double here = (between(measured.back().first - earlier, &Row::first, &Row::second) -
                         between(measured[2].first - earlier, &Row::first, &Row::second)) /
                        (measured.back().first - measured[2].first);
    CHECK(here == Approx(speed).epsilon(0.05));
    CHECK(simulation.totals().unconverged_solves == 0);
}

TEST_CASE("a standing wave, 40 particles long in water of 20 layers, has its period within 3 %", "[validation][sim]") {
    // Linear theory: omega^2 = g k tanh(k h), started flat with the velocities of its passage: u = U (sin kx cosh ky, -cos kx sinh ky)/sinh
    // kh. The wave's height is k A = 0.13, where the nonlinear period differs by 0.2 %. Two and a half periods lie between the first and
    // the sixth zero of the sum of u_y cos kx. Scattered at the start: a lattice melts meanwhile, and what that does to a wave lower than a
    // spacing makes the period 4 % short (1.6 % without damping).
    constexpr double length = 0.4, h = 0.2, U = 0.1, d = 0.01, k = 2 * std::numbers::pi / length;
    const Scene scene = read_scene_text(fmt::format(R"toml([time]
end = 2
max_step = 5e-3
[domain]
min = [0, -0.05, 0]
max = [{0}, 0.4, 0.06]
periodic = [true, false, true]
[fluid]
spacing = {1}
[models]
pressure = "ppe"
[[block]]
shape = "box"
min = [0, 0, 0]
max = [{0}, {2}, 0.06]
velocity = ["{3}*sin({4}*x)*cosh({4}*y)", "-{3}*cos({4}*x)*sinh({4}*y)", "0"]
sampling = "blue_noise"
[[solid]]
shape = "plane"
)toml",
                                                    length, d, h, U / std::sinh(k * h), k),
                                        "wave.toml");
    Simulation simulation(scene, make_plan(scene));
    const double period = 2 * std::numbers::pi / std::sqrt(g * k * std::tanh(k * h));
    Zeros zeros(period / 4);  // noise of a hundredth may cross to and fro within a step or two
    while (zeros.at.size() < 6 && simulation.time() < 2) {
        REQUIRE_FALSE(simulation.step(2).diverged);
        const auto x = simulation.world().fluid.column<field::position>();
        const auto u = simulation.world().fluid.column<field::velocity>();
        double now = 0;
        for (std::size_t i = 0; i < x.size(); ++i) now += static_cast<double>(u[i].y()) * std::cos(k * static_cast<double>(x[i].x()));
        zeros.sample(simulation.time(), now);
    }
    REQUIRE(zeros.at.size() == 6);
    CHECK((zeros.at[5] - zeros.at[0]) / 2.5 == Approx(period).epsilon(0.03));
}

}  // namespace waves_test
