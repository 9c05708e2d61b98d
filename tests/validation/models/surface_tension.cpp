/// Surface tension against exact solutions: the pressure in a drop, its oscillation, and its final shape.
#include "engine/models/surface_tension/surface_tension.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <catch2/catch.hpp>
#include <numbers>

#include "engine/models/motion/motion.h"
#include "engine/models/pressure/constraint.h"
#include "engine/models/pressure/damping.h"
#include "engine/particles/sample.h"
#include "tests/support/runs.h"
#include "tests/support/scene_text.h"
#include "tests/support/world.h"
#include "tests/support/zeros.h"

using namespace whorl;
using namespace whorl::test;

namespace surface_tension_test {

namespace {

constexpr double sigma = 0.07, rho = 1000, d = 1e-3;
const double unit = std::sqrt(rho * d * d * d / sigma);  // time in which surface tension moves a particle by a spacing [s]

/// A weightless drop of water-like fluid with the stages that models.pressure = "ppe" has.
struct Drop : TestWorld {
    double radius;  ///< of a ball of the same volume [m]
    explicit Drop(double across, unsigned seed = 1, Sampling sampling = Sampling::blue_noise)
        : TestWorld(d, 2, Domain{Vec3::Constant(Real(-2 * across * d)), Vec3::Constant(Real(2 * across * d)), {}}) {
        PressureOptions options;
        options.slow_correction = true;  // as scenes with surface tension have it
        options.limits = {1e-5, 1000};   // the test needs the pressure, not only the densities
        use({make_stage("surface tension", "", SurfaceTension{{sigma, {}, nullptr, true}}),
             make_stage("unresolved motion", "", DampUnresolved{2, sigma}),
             make_stage("density constraint", "", ConstraintPressure{options}), make_stage("move", "", Move{})});
        ShapeKeys ball;
        ball.kind = "sphere";
        ball.radius = across * d;
        const std::vector<Vec3> x = sample_shape(*make_shape(ball), sampling, Real(d), world.step.domain, seed);
        put(x);
        radius = d * std::cbrt(3 * static_cast<double>(x.size()) / (4 * std::numbers::pi));
        world.step.gravity.setZero();
    }
    static constexpr double share = 0.15;  ///< of `unit`, a step
    /// Steps for `units`; each removes the fraction `lost` of the velocity.
    void run(double units, double lost) {
        for (int k = 0; k < std::lround(units / share); ++k) {
            step(share * unit);
            for (Vec3& u : column<field::velocity>()) u *= Real(1 - lost);
        }
    }
    /// Mean pressure at depths of at least 4 d, where almost no cohesion acts: it balances the curved surface [Pa].
    double excess_pressure() {
        const auto x = column<field::position>();
        const auto p = column<field::pressure>();
        double sum = 0, count = 0;
        for (std::size_t i = 0; i < x.size(); ++i) {
            if (static_cast<double>(x[i].norm()) > radius - 4 * d) continue;
            sum += static_cast<double>(p[i]), ++count;
        }
        return sum / count;
    }
    /// Length along y minus width.
    double longer() {
        Vec3d square = Vec3d::Zero();
        for (const Vec3& x : column<field::position>()) square += x.cast<double>().cwiseAbs2();
        return std::sqrt(square.y() / (0.5 * (square.x() + square.z()))) - 1;
    }
};

/// The axes of the fluid by its second moments, the longest last.
Vec3d axes(Span<const Vec3> x) {
    Vec3d centre = Vec3d::Zero();
    for (const Vec3& one : x) centre += one.cast<double>() / static_cast<double>(x.size());
    Mat3d moments = Mat3d::Zero();
    for (const Vec3& one : x)
        moments += (one.cast<double>() - centre) * (one.cast<double>() - centre).transpose() / static_cast<double>(x.size());
    return Eigen::SelfAdjointEigenSolver<Mat3d>(moments).eigenvalues().cwiseSqrt();
}

/// Over 2 sigma/R, in the settled drop.
double settled_pressure(Drop& drop) {
    drop.run(20, 0.1);
    double excess = 0;
    for (int k = 0; k < 8; ++k) drop.run(0.6, 0.1), excess += drop.excess_pressure() / 8;
    return excess / (2 * sigma / drop.radius);
}

/// Pressure over 2 sigma/R, and period over Rayleigh's. u = k (-x/2, y, -z/2) sets the settled drop off, by a tenth of its radius: omega^2
/// = 8 sigma/(rho R^3).
std::pair<double, double> press_and_swing(Drop& drop) {
    const double pressure = settled_pressure(drop), omega = std::sqrt(8 * sigma / (rho * std::pow(drop.radius, 3))), k = 0.1 * omega;
    const double at_rest = drop.longer();
    for (std::size_t i = 0; i < drop.column<field::position>().size(); ++i) {
        const Vec3 x = drop.column<field::position>()[i];
        drop.column<field::velocity>()[i] = Real(k) * Vec3(-x.x() / 2, x.y(), -x.z() / 2);
    }
    Zeros crossings;
    double t = 0;
    while (crossings.at.size() < 3 && t * omega < 20) {
        drop.run(Drop::share, 0);
        t += Drop::share * unit;
        crossings.sample(t, drop.longer() - at_rest);
    }
    REQUIRE(crossings.at.size() == 3);
    return {pressure, (crossings.at[2] - crossings.at[0]) * omega / (2 * std::numbers::pi)};
}

}  // namespace

/// @param across radius over the spacing
void presses_however_begun(double across, std::initializer_list<Sampling> samplings) {
    // Without the spread of the pulls (SurfaceTensionOptions::spread) the constraint jams the skin: 0.74 to 0.88.
    for (const Sampling sampling : samplings) {
        Drop drop(across, 1, sampling);
        INFO("radius " << across << " d, sampling " << static_cast<int>(sampling));
        CHECK(settled_pressure(drop) == Approx(1).epsilon(0.1));
    }
}

TEST_CASE("a drop cut from a lattice or of blue noise has the pressure 2 sigma/R within 10 %",
          "[validation][surface_tension][regression]") {
    presses_however_begun(6, {Sampling::lattice, Sampling::blue_noise});
}

TEST_CASE("drops of 6, 8 and 11 spacings have the pressure 2 sigma/R within 10 % however they begin",
          "[validation][surface_tension][regression][long]") {
    presses_however_begun(6, {Sampling::jittered});
    for (const double across : {8, 11}) presses_however_begun(across, {Sampling::lattice, Sampling::jittered, Sampling::blue_noise});
}

TEST_CASE("a drop has the pressure 2 sigma/R within 12 % and Rayleigh's period within 5 %",
          "[validation][surface_tension][regression][long]") {
    // Means of three packings: single ones have a standard deviation of 8 % of the pressure and 4 % of the period at a radius of 6
    // spacings, 3 and 1.3 % at 8. Where all pairs pulled, the inside was pressed with nine to sixteen times 2 sigma/R. Skin::packed was
    // chosen by drops of 6, 8 and 11 spacings: it moves all pressures and periods together, not how they go with R/d.
    for (const double across : {6, 8, 11}) {
        double mean_pressure = 0, mean_period = 0;
        for (const unsigned seed : {1u, 2u, 3u}) {
            Drop drop(across, seed);
            const auto [pressure, period] = press_and_swing(drop);
            WARN("radius " << across << " d: pressure " << pressure << ", period " << period);
            mean_pressure += pressure / 3, mean_period += period / 3;
        }
        INFO("radius " << across << " d");
        CHECK(mean_pressure == Approx(1).epsilon(0.12));
        CHECK(mean_period == Approx(1).epsilon(0.05));
    }
}

TEST_CASE("a cube of fluid becomes a ball", "[validation][surface_tension]") {
    // Axes within 3 %, and no particle farther out than the ball's radius: a cube's corners are 40 % farther.
    for (const char* pressure : {"ppe", "coupled"}) {
        const double half = 4 * d;
        Simulation s =
            simulation_of(text::time(60 * unit) + text::domain({-0.02, -0.02, -0.02}, {0.02, 0.02, 0.02}, "gravity = [0, 0, 0]") +
                          text::fluid(d, 0.2, fmt::format("surface_tension = {}", sigma)) + text::models(pressure) +
                          text::block({-half, -half, -half}, {half, half, half}));
        run_until(s, 60 * unit);
        const auto x = positions(s);
        const Vec3d axis = axes(x);
        const double radius = d * std::cbrt(3 * static_cast<double>(x.size()) / (4 * std::numbers::pi));
        double farthest = 0;
        for (const Vec3& one : x) farthest = std::max(farthest, static_cast<double>(one.norm()));
        WARN(pressure << ": axes " << axis[0] / axis[2] << " and " << axis[1] / axis[2] << " of the longest, farthest particle at "
                      << farthest / radius << " of the radius");
        CHECK(axis[0] > 0.97 * axis[2]);
        CHECK(farthest < radius);
    }
}

TEST_CASE("a water drop that hangs from a nozzle falls on a neck, and leaves more than a tenth of its mass",
          "[validation][surface_tension][long]") {
    // Harkins and Brown 1919: 0.66 of 2 pi r sigma/g = 90 mg fall from a radius of 2 mm, 60 mg; at 15 mm/s 11 mg more pass the neck.
    // Measured with 5 spacings in the radius: 76 mg, and 15 mg stay. Without the spread of the pulls 105 mg still hang.
    Simulation drop = simulation_of(text::time(1) + text::domain({-0.006, -0.03, -0.006}, {0.006, 0.004, 0.006}) +
                                    text::fluid(4e-4, 0.001, "surface_tension = 0.07") + text::models("ppe") +
                                    "[[emitter]]\nposition = [0, 0, 0]\ndirection = [0, -1, 0]\nradius = 2e-3\nspeed = 0.015\n");
    const double particle = 1000 * 4e-4 * 4e-4 * 4e-4 * 1e6;  // mg
    // Particles below the lowest gap of two spacings, and those above it outside the nozzle.
    const auto parts = [&] {
        std::vector<Real> y;
        for (const Vec3& one : positions(drop))
            if (one.y() < 0) y.push_back(one.y());
        std::sort(y.begin(), y.end());
        std::size_t k = 1;
        while (k < y.size() && y[k] - y[k - 1] < Real(8e-4)) ++k;
        return std::pair(particle * static_cast<double>(k), particle * static_cast<double>(y.size() - std::min(k, y.size())));
    };
    std::pair<double, double> now{0, 0};
    while (drop.time() < 0.7 && !(now.first > 20 && now.second > 0)) run_until(drop, drop.time() + 0.005), now = parts();
    WARN("at " << drop.time() << " s " << now.first << " mg fall, " << now.second << " mg stay");
    CHECK(now.first == Approx(68).epsilon(0.2));
    CHECK(now.second > 0.12 * now.first);
}

TEST_CASE("a thread of water of 5 spacings breaks in a wave of 10.8 radii, at 0.4 of Rayleigh's rate or more",
          "[validation][surface_tension][long]") {
    // kR = 0.58: 245/s by Rayleigh 1879; measured 0.46 of it from a swing of the area of 0.25 to 1, and a gap after 27 ms.
    Simulation thread = simulation_of(
        text::time(1) +
        text::domain({-0.0025, 0, -0.0025}, {0.0025, 0.0054165, 0.0025}, "periodic = [false, true, false]\ngravity = [0, 0, 0]") +
        text::fluid(1e-4, 0.001, "surface_tension = 0.07") + text::models("ppe") +
        "[[block]]\nshape = \"cylinder\"\nfrom = [0, 0, 0]\nto = [0, 0.0054165, 0]\nradius = 0.0005\nvelocity = "
        "[\"0.05*0.29*x/5e-4*cos(1160*y)\", \"-0.05*sin(1160*y)\", \"0.05*0.29*z/5e-4*cos(1160*y)\"]\n");
    const auto swing = [&](double time) {
        run_until(thread, time);
        const auto x = positions(thread);
        double c = 0;
        for (const Vec3& one : x) c += std::cos(1160 * static_cast<double>(one.y())) * 2 / static_cast<double>(x.size());
        return c;
    };
    const double first = swing(0.01), rate = std::log(swing(0.0175) / first) / 0.0075;
    WARN("grows at " << rate / 245 << " of Rayleigh's rate");
    CHECK(rate > 0.4 * 245);
    CHECK(rate < 1.1 * 245);
    run_until(thread, 0.032);
    const auto x = positions(thread);
    CHECK(std::none_of(x.begin(), x.end(), [](const Vec3& one) { return std::abs(one.y() - Real(0.0054165 / 2)) < Real(1e-4); }));
}

}  // namespace surface_tension_test
