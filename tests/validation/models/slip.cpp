/// Walls to which the fluid sticks, or along which it slips by a length b: u - u_wall = b du/dn (Navier's condition), against exact flows.
#include <catch2/catch.hpp>
#include <cmath>

#include "engine/models/boundary/wall.h"
#include "tests/support/viscous_forms.h"

using namespace whorl;
using namespace whorl::test;

namespace slip_test {

namespace {

using Form = ViscousForm;

/// Steady flow along x between walls at y = 0 and y = H with separate slip lengths and velocities, driven by g. d u/dt = 0 in
///   nu u'' = -g,   u(0) - U0 = b0 u'(0),   u(H) - U1 = -b1 u'(H).
struct Channel {
    double H = 1, nu = 1, g = 0, U0 = 0, U1 = 0, b0 = 0, b1 = 0;
    double exact(double y) const {
        // u = U0 + s (y + b0) - g y^2/(2 nu);  the other wall gives the slope s
        const double s = (U1 - U0 + g / nu * (H * H / 2 + b1 * H)) / (H + b0 + b1);
        return U0 + s * (y + b0) - g / (2 * nu) * y * y;
    }
};

/// Starts from the exact flow and runs for 1.5 times the slowest mode's time. @return largest error of the velocity, over the exact flow's
/// range
double worst_error(Form form, const Channel& c, int across, int dimensions = 3) {
    const double d = c.H / across, support = support_of(form), width = 2 * std::ceil(support) * d, depth = dimensions == 3 ? width : 0;
    const Real factor = continued_lattice_factor({KernelKind::cubic, dimensions}, Real(support * d), Real(d));
    TestWorld w(d, support, Domain{Vec3::Zero(), Vec3(Real(width), Real(c.H), Real(depth)), {true, false, dimensions == 3}});
    w.use(viscous_step_of(form, factor, 1e-6));
    w.world.step.gravity = Vec3(Real(c.g), 0, 0);
    w.add_wall(1, +1, 0, c.b0);
    w.add_wall(1, -1, c.H, c.b1);
    w.move_wall(0, Vec3(Real(c.U0), 0, 0));
    w.move_wall(1, Vec3(Real(c.U1), 0, 0));
    w.place(Vec3::Zero(), Vec3(Real(width), Real(c.H), Real(depth)), 1000 * c.nu,
            [&](const Vec3& x) { return Vec3(Real(c.exact(x.y())), 0, 0); });
    // Slowest mode: with long slip lengths it is the mean velocity, which wall friction slows at about the rate nu (1/(b0 + H/2) + 1/(b1 +
    // H/2))/H.
    const double rate = c.nu / c.H * (1 / (c.b0 + c.H / 3) + 1 / (c.b1 + c.H / 3)), end = 2 / rate;
    const double dt = !is_implicit(form) ? 0.5 * viscous_step(support * d, c.nu) : end / 40;
    for (int s = 0; s < static_cast<int>(std::ceil(end / dt)); ++s) w.step(dt);
    const auto x = w.column<field::position>();
    const auto u = w.column<field::velocity>();
    double worst = 0, low = 1e30, high = -1e30;
    for (std::size_t i = 0; i < x.size(); ++i) {
        const double exact = c.exact(x[i].y());
        worst = std::max(worst, std::abs(u[i].x() - exact));
        low = std::min(low, exact), high = std::max(high, exact);
    }
    return worst / std::max(high - low, std::max(std::abs(high), std::abs(low)));
}

/// Couette flow (g = 0) with one slipping wall, 16 spacings across, or Poiseuille flow with two, 24 across. @param slip_lengths over the
/// spacing
void keeps_its_profile(double g, std::initializer_list<double> slip_lengths, int dimensions = 3) {
    const int across = g > 0 ? 24 : 16;
    for (Form form : viscous_forms)
        for (double b : slip_lengths) {
            Channel c;
            c.g = g, c.b0 = b * c.H / across;
            (g > 0 ? c.b1 : c.U1) = g > 0 ? c.b0 : 1;
            const double error = worst_error(form, c, across, dimensions);
            CAPTURE(g, name_of(form), b, error, dimensions);
            // Couette with the cubic kernel and R = 2 d: the same sum on both sides of the wall, exact to rounding. monaghan, with R = 4 d,
            // uses the kernel's density: next to a wall of one layer, up to 8 % too little. The fourth moments of a square lattice are less
            // isotropic than those of a cubic one.
            CHECK(error < (g == 0 ? 0.02 : form == Form::monaghan && b > 0 ? 0.05 : dimensions == 2 ? 0.022 : 0.02));
        }
}

}  // namespace

TEST_CASE("between walls that stick Couette flow is straight and Poiseuille flow a parabola within 2 %, in 2D",
          "[validation][viscosity][boundary][slip][plane]") {
    for (const double g : {0, 8}) keeps_its_profile(g, {0}, 2);
}

TEST_CASE("between a slipping wall at rest and a moving wall the profile is straight within 2 %, 16 d across",
          "[validation][viscosity][boundary][slip]") {
    keeps_its_profile(0, {0.5, 2});
}

TEST_CASE("plane Poiseuille flow with slip b is the parabola plus g b H/(2 nu) within 2 % (monaghan 5 %)",
          "[validation][viscosity][boundary][slip][regression]") {
    keeps_its_profile(8, {2});
}

TEST_CASE("walls with slips of 0.5 and 10 spacings keep both profiles within 2 % (explicit monaghan 5 %)",
          "[validation][viscosity][boundary][slip][long][regression]") {
    keeps_its_profile(0, {10});
    keeps_its_profile(8, {0.5, 10});
}

TEST_CASE("a slip length of 1e-6 d is a wall that sticks, one of 1e6 d a wall that slides freely",
          "[validation][viscosity][boundary][slip]") {
    const int across = 16;
    for (Form form : viscous_forms) {
        CAPTURE(name_of(form));
        // Sticking: Couette flow between both, with the bound of no-slip walls for the straight profile.
        Channel c;
        c.U1 = 1, c.b0 = 1e-6 * c.H / across, c.b1 = c.b0;
        CHECK(worst_error(form, c, across) < 0.02);
        // Sliding: walls of velocity 1 accelerate fluid at rest by 2 H/b each in a step of nu dt/H^2 = 2.
        TestWorld w(1.0 / across, support_of(form), Domain{Vec3::Zero(), Vec3(Real(0.5), 1, Real(0.5)), {true, false, true}});
        const Real factor = continued_lattice_factor(KernelKind::cubic, w.world.step.support, w.world.step.spacing);
        w.use(viscous_step_of(form, factor, 1e-6));
        w.world.step.gravity.setZero();
        w.add_wall(1, +1, 0, 1e6 / across);
        w.move_wall(0, Vec3(1, 0, 0));
        w.place(Vec3::Zero(), Vec3(Real(0.5), 1, Real(0.5)), 1000);
        w.step(!is_implicit(form) ? viscous_step(support_of(form) / across, 1) : 2);
        CHECK(w.max_speed() < 1e-4);
    }
}

}  // namespace slip_test
