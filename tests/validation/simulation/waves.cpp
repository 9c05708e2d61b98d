/// Water with a free surface against an experiment and against linear wave theory.
#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "tests/support/runs.h"
#include "tests/support/scene_text.h"
#include "tests/support/zeros.h"

using namespace whorl;
using namespace whorl::test;

namespace waves_test {

namespace {

constexpr double g = 9.81;

/// Velocities of a standing wave as it passes flat: U (sin kx cosh ky, -cos kx sinh ky).
std::string passage(double U, double k) {
    return fmt::format("velocity = [\"{0}*sin({1}*x)*cosh({1}*y)\", \"-{0}*cos({1}*x)*sinh({1}*y)\"]", U, k);
}

}  // namespace

TEST_CASE("the front of a collapsing column is within 5 % of the experiment at every tabulated time", "[validation][sim]") {
    // Martin and Moyce 1952, table 2: a column of width a = 2.25 in and height 2 a; Z = x/a at T = t sqrt(2 g/a). There a membrane bursts
    // before the water moves, and the time of the burst is not known accurately. Times therefore count from the table's first row, Z
    // = 1.22, which the water that is free at once reaches 0.15 in T earlier. 3.5 % were measured; in T as printed the front leads by 6 to
    // 14 %. Its mean speed is within 5 %, too.
    constexpr double a = 0.05715;
    const std::vector<std::pair<double, double>> measured{{0.84, 1.22}, {1.19, 1.44}, {1.43, 1.67}, {1.63, 1.89}, {1.83, 2.11},
                                                          {1.98, 2.33}, {2.20, 2.56}, {2.32, 2.78}, {2.51, 3.00}, {2.65, 3.22},
                                                          {2.83, 3.44}, {2.98, 3.67}, {3.11, 3.89}};
    const double d = a / 20;
    Simulation simulation =
        simulation_of(text::time(1, "max_step = 5e-3") + text::domain({-3 * d, -3 * d}, {6 * a, 3 * a}) + text::fluid(d) +
                      text::models("ppe") + text::block({0, 0}, {a, 2 * a}) + text::plane({0, 0}, {0, 1}) + text::plane({0, 0}, {1, 0}));
    const double second = std::sqrt(2 * g / a);
    std::vector<std::pair<double, double>> run{{0, 1}};
    while (run.back().second < measured.back().second && run.back().first < 4) {
        REQUIRE_FALSE(simulation.step(1).diverged);
        std::vector<Real> x;
        for (const Vec3& one : positions(simulation)) x.push_back(one.x());
        // Two particles may be drops ahead of the front.
        std::nth_element(x.begin(), x.end() - 3, x.end());
        run.emplace_back(simulation.time() * second, (x[x.size() - 3] + d / 2) / a);
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
    // the sixth zero of the sum of u_y cos kx. Scattered at the start: a lattice melts meanwhile, which makes the period of a wave lower
    // than a spacing 4 % short (1.6 % without damping).
    constexpr double length = 0.4, h = 0.2, U = 0.1, d = 0.01, k = 2 * std::numbers::pi / length;
    Simulation simulation = simulation_of(
        text::time(2, "max_step = 5e-3") + text::domain({0, -0.05}, {length, 0.4}, "periodic = [true, false]") + text::fluid(d) +
        text::models("ppe") + text::block({0, 0}, {length, h}, "sampling = \"blue_noise\"\n" + passage(U / std::sinh(k * h), k)) +
        text::plane({0, 0}, {0, 1}));
    const double period = 2 * std::numbers::pi / std::sqrt(g * k * std::tanh(k * h));
    // Noise of 1 % may cross zero repeatedly within a step or two.
    const Oscillation found = oscillation(simulation, 6, period / 4, 2, [&] { return vertical_wave(simulation, k); });
    CHECK(found.period == Approx(period).epsilon(0.03));
}

namespace {

/// Amplitude of the period `period` in samples (t, value) [s]: least squares with the mean and the second harmonic.
double amplitude(const std::vector<std::pair<double, double>>& samples, double period) {
    Eigen::MatrixXd terms(static_cast<Eigen::Index>(samples.size()), 5);
    Eigen::VectorXd values(terms.rows());
    for (Eigen::Index i = 0; i < terms.rows(); ++i) {
        const auto& [t, value] = samples[static_cast<std::size_t>(i)];
        const double phase = 2 * std::numbers::pi * t / period;
        terms.row(i) << 1, std::cos(phase), std::sin(phase), std::cos(2 * phase), std::sin(2 * phase);
        values[i] = value;
    }
    const Eigen::VectorXd fit = terms.colPivHouseholderQr().solve(values);
    return std::hypot(fit[1], fit[2]);
}

/// 40 particles by 16 in a tank with smooth walls: half a wave, started flat with the velocities of its passage, U at the surface.
Simulation seiche(double length, double U, const std::string& sampling = "lattice", const std::string& form = "projection") {
    const double h = 0.4 * length, k = std::numbers::pi / length;
    return simulation_of(text::time(4) + text::domain({-length / 5, -length / 5}, {1.2 * length, 0.8 * length}) + text::fluid(length / 40) +
                         text::pressure_form(form) +
                         text::block({0, 0}, {length, h}, fmt::format("sampling = \"{}\"\n", sampling) + passage(U / std::sinh(k * h), k)) +
                         text::tank({0, 0}, {length, 1}, "slip = \"free\""));
}

/// Half a wave in a tank of 0.5 m with water 0.2 m deep and smooth walls: omega^2 = g k tanh(k h), k = pi/0.5. Started flat with the
/// velocities of its passage, 1.3 spacings high. The projection's period is 1 % longer, without loss; the constraint's 3 % shorter, and
/// it loses 15 % a period (33 % when walls showed no images). @param periods to compare the first and the last of
void seiche_keeps(const std::string& form, int periods, double kept_per_period, double tolerance_of_period) {
    INFO(form);
    constexpr double length = 0.5, h = 0.2, U = 0.12, k = std::numbers::pi / length;
    Simulation simulation = seiche(length, U, "lattice", form);
    const double period = 2 * std::numbers::pi / std::sqrt(g * k * std::tanh(k * h));
    Zeros zeros(period / 4);
    std::vector<std::pair<double, double>> first, last;
    run_until(simulation, periods * period, [&] {
        const double now = mean_of(simulation, [&](const Vec3d& x, const Vec3d& u) { return u.x() * std::sin(k * x.x()); });
        zeros.sample(simulation.time(), now);
        if (simulation.time() < period) first.emplace_back(simulation.time(), now);
        if (simulation.time() > (periods - 1) * period) last.emplace_back(simulation.time(), now);
    });
    const std::size_t whole = 2 * static_cast<std::size_t>(periods - 1);
    REQUIRE(zeros.at.size() > whole);
    CHECK((zeros.at[whole] - zeros.at[0]) / (periods - 1) == Approx(period).epsilon(tolerance_of_period));
    const double kept = amplitude(last, period) / amplitude(first, period);
    CHECK(kept > std::pow(kept_per_period, periods - 1));
    CHECK(kept < 1.03);
}

}  // namespace

TEST_CASE("over 3 periods a seiche loses less than 3 % per period with projection, 18 % with the constraint",
          "[validation][sim][waves][long]") {
    seiche_keeps("projection", 4, 0.97, 0.02);
    seiche_keeps("constraint", 4, 0.82, 0.05);
}

TEST_CASE("steep sloshes hold with the projection, crests of half the depth among them", "[validation][sim][waves]") {
    // The seiche above, 40 particles by 16 in a tank of 1 m, with 0.8 and 1.1 m/s at its passage: crests of half and of three quarters of
    // the depth. Its energy above that of still water may not grow by more than a fifth (measured: 12 %, when particles settle), and some
    // must be left after two periods. With each of three samplings 0.3 to 0.8 m/s hold for 4 s; two of three with 1.1 m/s die after 3 s.
    for (const auto& [U, sampling] : {std::pair{0.8, "lattice"}, std::pair{1.1, "jittered"}}) {
        INFO(U << " m/s, " << sampling);
        Simulation simulation = seiche(1, U, sampling);
        const auto energy = [&] {
            return mean_of(simulation, [](const Vec3d& x, const Vec3d& u) { return u.squaredNorm() / 2 + g * (x.y() - 0.2); });
        };
        const double first = energy();
        run_until(simulation, 2.4, [&] { REQUIRE(energy() < 1.2 * first); });
        CHECK(energy() > 0.3 * first);
    }
}

TEST_CASE("piston waves 1.7 spacings high have the height of theory within 8 % over a wavelength", "[validation][sim][waves][long]") {
    // Depth 0.25 m, period 1.1 s, stroke 0.04 m: H = 0.0414 m and 1.48 m from crest to crest in linear theory. With half the spacing
    // 0.0404 m was measured at 1 m from the piston and 0.0403 m at 3 m. The constraint has 0.030 and
    // 0.013 m here.
    const std::string free = "slip = \"free\"\n", piston = "position = [\"0.02*(1-cos(2*pi*t/1.1))\", \"0\"]\n";
    Simulation simulation =
        simulation_of(text::time(5) + text::domain({-0.3, -0.1}, {4.7, 0.55}) + text::fluid(0.025) + text::pressure_form("projection") +
                      text::block({0, 0}, {4.4, 0.25}) + text::box({-0.5, -0.1}, {4.6, 0}, free) +
                      text::box({4.4, -0.1}, {4.6, 0.55}, free) + text::box({-0.2, 0}, {0, 0.55}, piston + free));
    // Depth, weighted by a hat of 0.15 m to both sides. It measures (sin(k b/2)/(k b/2))^2 of the wave's height.
    constexpr double b = 0.15;
    std::vector<std::pair<double, double>> near, far;
    const auto depth = [&](double at) {
        double sum = 0;
        for (const Vec3& x : positions(simulation)) sum += std::max(0.0, 1 - std::abs(x.x() - at) / b);
        return sum * 0.025 * 0.025 / b;
    };
    run_until(simulation, 2.8);
    run_until(simulation, 5, [&] {
        near.emplace_back(simulation.time(), depth(1));
        far.emplace_back(simulation.time(), depth(2.5));
    });
    const double half = std::numbers::pi / 1.483 * b, seen = std::pow(std::sin(half) / half, 2);
    const double height_near = 2 * amplitude(near, 1.1) / seen, height_far = 2 * amplitude(far, 1.1) / seen;
    CHECK(height_near == Approx(0.0414).epsilon(0.08));
    CHECK(height_far == Approx(0.0414).epsilon(0.08));
    CHECK(height_far / height_near == Approx(1).epsilon(0.08));
}

TEST_CASE("a dam break on a wet bed has Stoker's depth within 2 %, its bore's position within 6 %", "[validation][sim]") {
    // Stoker 1957, section 10.8: a bore and a rarefaction with u + 2 c of the high water meet in water of depth h at the speed u. 16 and 8
    // layers.
    constexpr double high = 0.2, low = 0.1, d = 0.0125;
    double h = low, above = high;
    for (int k = 0; k < 60; ++k) {
        const double mid = (h + above) / 2, u = (mid - low) * std::sqrt(g / 2 * (mid + low) / (mid * low));
        (u < 2 * (std::sqrt(g * high) - std::sqrt(g * mid)) ? h : above) = mid;
    }
    const double u = 2 * (std::sqrt(g * high) - std::sqrt(g * h));
    Simulation dam =
        simulation_of(text::time(1) + text::domain({-1.2, -0.05}, {1.2, 0.4}) + text::fluid(d) + text::block({-1.1, 0}, {0, high}) +
                      text::block({0, 0}, {1.1, low}) + text::tank({-1.1, 0}, {1.1, 0.4}, "slip = \"free\""));
    const auto volume = [&](double from, double to) {
        const auto x = positions(dam);
        return d * d *
               static_cast<double>(std::count_if(x.begin(), x.end(), [&](const Vec3& one) { return one.x() > from && one.x() < to; }));
    };
    run_until(dam, 0.6);
    const double bore = u * h / (h - low) * 0.6;
    double front = 1;
    while (volume(front - 0.05, front) / 0.05 < (h + low) / 2) front -= d / 4;
    CHECK(volume(0.05, bore - 0.2) / (bore - 0.25) == Approx(h).epsilon(0.02));
    CHECK(front - 0.025 == Approx(bore).epsilon(0.06));
}

TEST_CASE("water flows under a sluice gate with the jet's theoretical contraction within 2 %", "[validation][sim][long]") {
    // An opening of 8 spacings under a depth of 40 to 34: the jet contracts to 0.60 of the opening (0.611 in deep water, Kirchhoff 1869),
    // and its head is the mean depth behind the gate less its own: q = C a sqrt(2 g (H - C a)). The water starts with the velocity that
    // this q needs, or it would slosh.
    constexpr double d = 0.01, a = 8 * d, contraction = 0.6, length = 0.8;
    const std::string free = "slip = \"free\"";
    Simulation tank = simulation_of(text::time(2) + text::domain({-0.9, -0.1}, {1, 0.6}) + text::fluid(d) +
                                    text::block({-length, 0}, {0, 0.4}, "velocity = [\"0.38*(x+0.8)\", \"-0.38*y\", 0]") +
                                    text::box({-0.9, -0.1}, {1, 0}, free) + text::box({-0.9, 0}, {-length, 0.6}, free) +
                                    text::box({0, a}, {0.04, 0.6}, free) + text::drain({0.5, 0}, {1, 0.6}));
    const auto depth = [&] {
        const auto x = positions(tank);
        return d * d / length * static_cast<double>(std::count_if(x.begin(), x.end(), [&](const Vec3& one) { return one.x() < 0; }));
    };
    run_until(tank, 0.1);
    double H = depth(), t = 0.1;
    const double start = H;
    for (; t < 0.5; t += 1e-4) H -= 1e-4 * contraction * a / length * std::sqrt(2 * g * (H - contraction * a));
    run_until(tank, 0.5);
    CHECK(start - depth() == Approx(start - H).epsilon(0.02));
}

}  // namespace waves_test
