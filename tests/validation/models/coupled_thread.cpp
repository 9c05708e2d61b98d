/// Threads of the coupled solve against slender-body theory: pulled apart, and bent.
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "tests/support/coupled_world.h"

using namespace whorl;
using namespace whorl::test;

namespace coupled_thread_test {

namespace {

constexpr Real d = 0.002;
constexpr double a0 = 2.5 * d, mu = 1000, clamp = 3 * d, dt = 2e-3, volume = double(d) * d * d;

/// A thread along y whose first and last 3 d are held.
struct HeldThread : CoupledWorld {
    double length;
    /// @param spacings length over d @param radius over d
    explicit HeldThread(Real spacings, Real radius = Real(2.5), unsigned seed = 1)
        : CoupledWorld(blue_noise_cylinder(radius * d, spacings * d, d, seed), d, 1), length(spacings * d) {
        for (std::size_t i = 0; i < position().size(); ++i)
            role()[i] = position()[i][1] < clamp ? -1 : position()[i][1] > length - clamp ? -2 : 0;
    }

    /// One step in which the upper end moves so that the thread's length grows at the relative rate `rate` [1/s].
    bool pull(double rate) {
        for (std::size_t i = 0; i < position().size(); ++i)
            if (role()[i] != 0) velocity()[i] = Vec3(0, role()[i] == -2 ? Real(rate * length) : 0, 0);
        length += dt * rate * length;
        return step(Real(dt));
    }

    /// Solves again at the current positions, and passes each particle's force by its neighbours [N], from the discrete form, to `visit`.
    template <class F>
    void internal_forces(const F& visit) {
        solve_only(Real(dt));
        const StrainForm& form = system->form;
        const auto u = velocity(), x = position();
        const auto p = world.fluid.column<field::pressure>();
        const auto G = world.fluid.column<field::velocity_gradient>();
        const std::size_t n = u.size();
        const double rho = world.step.rest_density;
        // The step's load q = dt (p_old + lambda s)/(rho d), and p_new = memory (p_old + lambda s - lambda tr D).
        std::vector<Vec3> force(n, Vec3::Zero()), rate(n);
        std::vector<Real> q(n);
        for (std::size_t i = 0; i < n; ++i) {
            const auto k = static_cast<Index>(i);
            const double lambda = double(form.coefficients(k).bulk) * rho * d * d / dt;
            q[i] = static_cast<Real>(dt / (rho * d) * (double(p[i]) / system->options.memory + lambda * double(form.divergence(k, G[i]))));
        }
        form.apply(u, rate);
        form.add_stress(q, {}, force);
        for (std::size_t i = 0; i < n; ++i)
            visit(x[i].cast<double>(), u[i].cast<double>(),
                  Vec3d(double(world.step.mass) / dt * (force[i] + u[i] - rate[i]).cast<double>()));
    }
};

}  // namespace

TEST_CASE("a thread pulled at a constant rate carries Trouton's 3 mu A rate, thins and does not tear", "[validation][coupled]") {
    HeldThread w(24);
    const double rate = 5;
    std::vector<std::size_t> middle;  // the same particles throughout
    for (std::size_t i = 0; i < w.position().size(); ++i)
        if (std::abs(w.position()[i][1] - w.length / 2) < 5 * d) middle.push_back(i);
    // u_y = c + e y over the middle; its length by the spread of its particles.
    struct Fit {
        double centre = 0, spread = 0, rate = 0;
    };
    const auto fit = [&] {
        Fit f;
        double v = 0, vy = 0;
        for (std::size_t i : middle)
            f.centre += w.position()[i][1] / double(middle.size()), v += w.velocity()[i][1] / double(middle.size());
        for (std::size_t i : middle) {
            const double y = w.position()[i][1] - f.centre;
            f.spread += y * y, vy += y * (w.velocity()[i][1] - v);
        }
        f.rate = vy / f.spread;
        f.spread = std::sqrt(f.spread);
        return f;
    };
    // Root mean square: the radius follows it, whatever way the particles fill the cross-section at the start.
    const auto distance_from_axis = [&] {
        Vec3d centre = Vec3d::Zero();
        for (std::size_t i : middle) centre += w.position()[i].cast<double>() / double(middle.size());
        double r2 = 0;
        for (std::size_t i : middle) {
            const Vec3d r = w.position()[i].cast<double>() - centre;
            r2 += (r[0] * r[0] + r[2] * r[2]) / double(middle.size());
        }
        return std::sqrt(r2);
    };
    const double spread0 = fit().spread, start = distance_from_axis();
    INFO("rms distance at the start over that of an even filling: " << start * std::sqrt(2) / a0);
    double drawn = 1, next_check = 2;
    int converged = 0, steps = 0;
    while (drawn < 4) {
        converged += w.pull(rate);
        ++steps;
        drawn = fit().spread / spread0;
        REQUIRE(steps < 1000);
        if (drawn < next_check) continue;
        next_check *= 2;
        INFO("draw " << drawn);
        const double expected = a0 / std::sqrt(drawn);

        std::vector<Vec3d> points;
        for (std::size_t i : middle) points.push_back(w.position()[i].cast<double>());
        const double radius = a0 * distance_from_axis() / start;

        const Fit now = fit();
        double tension = 0;
        w.internal_forces([&](const Vec3d& x, const Vec3d&, const Vec3d& force) {
            if (x[1] > now.centre) tension -= force[1];
        });
        const double trouton = tension / (mu * std::numbers::pi * expected * expected * now.rate), link = longest_link(points) / d;
        WARN("draw " << drawn << ": Trouton ratio " << trouton / 3 << " of 3, radius " << radius / expected << " of theory, longest link "
                     << link << " d");
        if (drawn < 3) {
            CHECK(trouton == Approx(3).epsilon(0.05));
            CHECK(radius == Approx(expected).epsilon(0.03));
        } else {
            CHECK(link < 1.6);
        }
    }
    CHECK(converged == steps);
}

TEST_CASE("a thread pulled until it is a single file of particles stays connected and carries 3 mu A rate",
          "[validation][coupled][regression]") {
    // 20 particles a spacing of length at the start, one at a draw of 20: then a spacing apart along the axis. Stretching widens every gap
    // in proportion; without shifting along the axis the first gap of two spacings opens between draws of 9 and 12 and the thread tears at
    // 13 to 16. Measured: tension 0.99 to 1.04 of 3 mu A rate down to 1.2 particles a spacing, 0.91 to 1.10 at one, where particles
    // alternate between left and right of the axis.
    for (const unsigned seed : {1u, 2u, 3u}) {
        HeldThread w(24, Real(2.5), seed);
        const double rate = 5;
        double drawn = 1, next_check = 4;
        for (int steps = 0; drawn < 20; ++steps) {
            REQUIRE(steps < 800);
            CHECK(w.pull(rate));
            // The middle half of the free part: its line density gives the cross-section, its velocities the rate.
            double low = 1e9, high = -1e9;
            for (std::size_t i = 0; i < w.position().size(); ++i)
                if (w.role()[i] == 0) low = std::min<double>(low, w.position()[i][1]), high = std::max<double>(high, w.position()[i][1]);
            const double centre = (low + high) / 2, half = (high - low) / 4;
            std::vector<Vec3d> middle;
            double y = 0, u = 0, yy = 0, uy = 0;
            for (std::size_t i = 0; i < w.position().size(); ++i) {
                const Vec3d x = w.position()[i].cast<double>();
                if (std::abs(x[1] - centre) > half) continue;
                const double v = double(w.velocity()[i][1]), s = x[1] - centre;
                middle.push_back(x), y += s, u += v, yy += s * s, uy += s * v;
            }
            const double n = static_cast<double>(middle.size()), local_rate = (uy - y * u / n) / (yy - y * y / n),
                         area = n * volume / (2 * half);
            drawn = std::numbers::pi * a0 * a0 / area;
            if (drawn < next_check) continue;
            next_check = next_check < 16 ? 2 * next_check : 20;

            constexpr int cuts = 5;  // mean of five cross-sections; the tension is equal in all of them except for inertia
            double tension = 0, from_axis = 0, shortest = 1e9;
            w.internal_forces([&](const Vec3d& x, const Vec3d&, const Vec3d& force) {
                for (int k = 0; k < cuts; ++k)
                    if (x[1] > centre + (0.3 * k - 0.6) * half) tension -= force[1] / cuts;
            });
            for (std::size_t i = 0; i < middle.size(); ++i) {
                from_axis += (middle[i][0] * middle[i][0] + middle[i][2] * middle[i][2]) / n;
                for (std::size_t j = 0; j < i; ++j) shortest = std::min(shortest, (middle[i] - middle[j]).norm());
            }
            const double share = tension / (3 * mu * area * local_rate), link = longest_link(middle) / d;
            WARN("seed " << seed << ", draw " << drawn << ": " << n * d / (2 * half) << " particles a spacing, " << share
                         << " of 3 mu A rate, longest link " << link << " d, shortest distance " << shortest / d << " d, "
                         << std::sqrt(from_axis) / d << " d from the axis");
            CHECK(share == Approx(1).epsilon(drawn < 18 ? 0.05 : 0.15));
            CHECK(link < 2);
            CHECK(shortest > 0.6 * d);  // no clumps
            CHECK(std::sqrt(from_axis) <
                  std::max(0.6 * d, 1.1 * std::sqrt(area / (2 * std::numbers::pi))));  // 1 for an even rod, so it does not buckle
        }
    }
}

TEST_CASE("a thread bends with 3 mu I within 15 % down to a radius of 1.5 particles", "[validation][coupled]") {
    // Both ends turn like the cross-sections of a thread whose curvature grows evenly: u = (k y^2/2, -k x y). A moment, no shear, no
    // tension.
    for (const double radius : {2.5, 2.0, 1.5}) {
        HeldThread w(20, Real(radius));
        const double k = 1, middle = w.length / 2, a = radius * d;
        for (std::size_t i = 0; i < w.position().size(); ++i) {
            const double x = w.position()[i][0], y = w.position()[i][1] - middle;
            w.velocity()[i] = Vec3(Real(k * y * y / 2), Real(-k * x * y), 0);
        }
        for (int step = 0; step < 60; ++step) w.solve_only(Real(dt));  // until inertia and the multiplier have settled

        double moment = 0, n = 0, s2 = 0, s4 = 0, b = 0, b2 = 0;
        w.internal_forces([&](const Vec3d& x, const Vec3d& u, const Vec3d& force) {
            const double y = x[1] - middle;
            for (const double cut : {-4.0, -2.0, 0.0, 2.0, 4.0})
                if (y > cut * d) moment += (x[0] * force[1] - (y - cut * d) * force[0]) / 5;
            if (std::abs(y) > 6 * d) return;
            n += 1, s2 += y * y, s4 += std::pow(y, 4), b += u[0], b2 += u[0] * y * y;  // u_x = c + k y^2/2
        });
        const double curvature_rate = 2 * (n * b2 - s2 * b) / (n * s4 - s2 * s2);
        const double stiffness = std::abs(moment) / (3 * mu * std::numbers::pi / 4 * std::pow(a, 4) * curvature_rate);
        WARN("radius " << radius << " d: bending stiffness " << stiffness << " of theory, curvature rate " << curvature_rate / k
                       << " of the ends'");
        CHECK(stiffness == Approx(1).epsilon(0.15));
    }
}

}  // namespace coupled_thread_test
