/// A thread of syrup with surface tension: Plateau's limit and the rate at which it beads.
#include <catch2/catch.hpp>
#include <numbers>

#include "engine/models/surface_tension/surface_tension.h"
#include "tests/support/coupled_world.h"

using namespace whorl;
using namespace whorl::test;

namespace capillary_thread_test {

namespace {

constexpr double sigma = 0.07, rho = 1000, d = 1e-3, pi = std::numbers::pi;

/// A weightless thread along y, periodic, one wave long.
struct Thread : CoupledWorld {
    double length, radius = 3 * d, time_step;
    Thread(double wave, double ohnesorge)
        : CoupledWorld(blue_noise_cylinder(Real(3 * d), Real(wave * d), Real(d)), Real(d),
                       Real(ohnesorge * std::sqrt(sigma * 3 * d / rho))),
          length(wave * d) {
        SurfaceTensionOptions options{sigma, {}, system->known_pressure};
        stages.insert(stages.begin() + 2, make_stage("surface tension", "", SurfaceTension(options)));
        world.step.domain =
            Domain{Vec3(Real(-20 * d), 0, Real(-20 * d)), Vec3(Real(20 * d), Real(length), Real(20 * d)), {false, true, false}};
        world.step.gravity.setZero();
        time_step = surface_tension_step(rho, d, sigma, ohnesorge * std::sqrt(rho * sigma * radius));
    }
    /// Amplitude a of the area A(y) = A0 (1 + a cos ky).
    double swing() {
        double c = 0, s = 0;
        for (const Vec3& x : position()) c += std::cos(2 * pi * double(x.y()) / length), s += std::sin(2 * pi * double(x.y()) / length);
        return 2 * std::hypot(c, s) / static_cast<double>(position().size());
    }
    /// The wave begins with the relative amplitude a of the area, growing at the rate omega.
    void disturb(double a, double omega) {
        const double k = 2 * pi / length;
        const auto x = position();
        const auto u = velocity();
        for (std::size_t i = 0; i < x.size(); ++i) {
            // Towards y = 0 along the thread, outwards there: div = 0.
            const double y = x[i].y();
            const Vec3 shift(Real(a / 2 * std::cos(k * y)) * x[i].x(), Real(-a / k * std::sin(k * y)),
                             Real(a / 2 * std::cos(k * y)) * x[i].z());
            x[i] += shift;
            u[i] += Real(omega) * shift;
        }
        for (Vec3& one : x) one = world.step.domain.wrapped(one);
    }
};

}  // namespace

TEST_CASE("coupled: a thread of syrup beads in waves longer than its circumference and smooths shorter ones",
          "[validation][coupled][surface_tension]") {
    // Radius 3 d, Ohnesorge number 0.5. The rate by which a swing of the area grows from 0.2 to 0.6 against the slender thread's (Eggers
    // and Dupont 1994; Weber 1931 with the full curvature): omega/omega0 = sqrt(x^2 (1 - x^2)/2 + 9/4 Oh^2 x^4) - 3/2 Oh x^2, x = k R,
    // omega0^2 = sigma/(rho R^3).
    const double Oh = 0.5, omega0 = std::sqrt(sigma / (rho * std::pow(3 * d, 3)));
    {
        Thread thread(38, Oh);
        const double x = 2 * pi * thread.radius / thread.length;
        const double omega = omega0 * (std::sqrt(0.5 * x * x * (1 - x * x) + 2.25 * Oh * Oh * x * x * x * x) - 1.5 * Oh * x * x);
        thread.disturb(0.15, omega);
        double begin = 0, end = 0, first = 0, last = 0;
        while (thread.time * omega < 6 && thread.swing() < 1) {
            REQUIRE(thread.step(Real(thread.time_step)));
            const double now = thread.swing();
            if (first == 0 && now > 0.2) first = now, begin = thread.time;
            if (now < 0.6) last = now, end = thread.time;
        }
        const double rate = std::log(last / first) / (end - begin);
        WARN("growth " << rate / omega << " of the slender thread's, a swing of " << thread.swing() << " after " << thread.time * omega
                       << " of its times, steps of " << thread.time_step);
        CHECK(thread.swing() > 1);
        CHECK(rate == Approx(omega).epsilon(0.25));
    }
    {
        Thread thread(13.5, Oh);
        thread.disturb(0.15, 0);
        while (thread.time * omega0 < 8) REQUIRE(thread.step(Real(thread.time_step)));
        WARN("short wave: a swing of " << thread.swing() << " is left");
        CHECK(thread.swing() < 0.08);
    }
}

}  // namespace capillary_thread_test
