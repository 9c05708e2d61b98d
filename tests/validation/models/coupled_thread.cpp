/// Threads of the coupled solve against slender-body theory: pulled apart, and bent.
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "tests/support/coupled_world.h"

using namespace whorl;
using namespace whorl::test;

namespace {

constexpr Real d = 0.002;
constexpr double a0 = 2.5 * d, mu = 1000, clamp = 3 * d, dt = 2e-3;

/// A thread along y whose first and last 3 d are held.
struct HeldThread : CoupledWorld {
    double length;
    explicit HeldThread(Real spacings) : CoupledWorld(blue_noise_cylinder(Real(2.5) * d, spacings * d, d), d, 1), length(spacings * d) {
        for (std::size_t i = 0; i < position().size(); ++i) role()[i] = position()[i][1] < clamp ? -1 : position()[i][1] > length - clamp ? -2 : 0;
    }

    /// Solves once more where the particles are, and hands `visit` each particle's force by its neighbours [N]: what the discrete form itself says.
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
        form.add_pressure(q, force);
        for (std::size_t i = 0; i < n; ++i)
            visit(x[i].cast<double>(), u[i].cast<double>(), Vec3d(double(world.step.mass) / dt * (force[i] + u[i] - rate[i]).cast<double>()));
    }
};

/// The longest link of the shortest tree that joins all points: a gap shows as a long one.
double longest_link(const std::vector<Vec3d>& x) {
    std::vector<double> nearest(x.size(), 1e30);
    std::vector<bool> joined(x.size(), false);
    double longest = 0;
    for (std::size_t step = 0, at = 0; step + 1 < x.size(); ++step) {
        joined[at] = true;
        std::size_t next = 0;
        double least = 1e30;
        for (std::size_t i = 0; i < x.size(); ++i) {
            if (joined[i]) continue;
            nearest[i] = std::min(nearest[i], (x[i] - x[at]).norm());
            if (nearest[i] < least) least = nearest[i], next = i;
        }
        longest = std::max(longest, least);
        at = next;
    }
    return longest;
}

}  // namespace

TEST_CASE("a thread pulled at a constant rate carries Trouton's 3 mu A rate, thins as its length says, and does not tear", "[validation][coupled]") {
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
        for (std::size_t i : middle) f.centre += w.position()[i][1] / double(middle.size()), v += w.velocity()[i][1] / double(middle.size());
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
    double drawn = 1, length = w.length, next_check = 2;
    int converged = 0, steps = 0;
    while (drawn < 4) {
        for (std::size_t i = 0; i < w.position().size(); ++i)
            if (w.role()[i] != 0) w.velocity()[i] = Vec3(0, w.role()[i] == -2 ? Real(rate * length) : 0, 0);
        converged += w.step(Real(dt));
        length += dt * rate * length;
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
        WARN("draw " << drawn << ": Trouton ratio " << trouton / 3 << " of 3, radius " << radius / expected << " of theory, longest link " << link << " d");
        if (drawn < 3) {
            CHECK(trouton == Approx(3).epsilon(0.05));
            CHECK(radius == Approx(expected).epsilon(0.03));
        } else {
            CHECK(link < 1.6);
        }
    }
    CHECK(converged == steps);
}

TEST_CASE("a thread of 2.5 particles' radius bends with 3 mu I within 15 %", "[validation][coupled]") {
    // Both ends turn like the cross-sections of a thread whose curvature grows evenly: u = (k y^2/2, -k x y). A moment, no shear, no tension.
    HeldThread w(20);
    const double k = 1, middle = w.length / 2;
    for (std::size_t i = 0; i < w.position().size(); ++i) {
        const double x = w.position()[i][0], y = w.position()[i][1] - middle;
        w.velocity()[i] = Vec3(Real(k * y * y / 2), Real(-k * x * y), 0);
    }
    for (int step = 0; step < 60; ++step) w.solve_only(Real(dt));  // until inertia and the multiplier have settled

    double moment = 0, n = 0, s2 = 0, s4 = 0, b = 0, b2 = 0;
    w.internal_forces([&](const Vec3d& x, const Vec3d& u, const Vec3d& force) {
        const double y = x[1] - middle;
        if (y > 0) moment += x[0] * force[1] - y * force[0];
        if (std::abs(y) > 6 * d) return;
        n += 1, s2 += y * y, s4 += std::pow(y, 4), b += u[0], b2 += u[0] * y * y;  // u_x = c + k y^2/2
    });
    const double curvature_rate = 2 * (n * b2 - s2 * b) / (n * s4 - s2 * s2);
    const double stiffness = std::abs(moment) / (3 * mu * std::numbers::pi / 4 * std::pow(a0, 4) * curvature_rate);
    WARN("bending stiffness " << stiffness << " of theory, curvature rate " << curvature_rate / k << " of the ends'");
    CHECK(stiffness == Approx(1).epsilon(0.15));
}
