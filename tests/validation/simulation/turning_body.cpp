/// Effect of the time step on rotating free bodies of fluid.
#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/support/runs.h"
#include "tests/support/scene_text.h"

using namespace whorl;
using namespace whorl::test;

namespace turning_body_test {

namespace {

constexpr double turning = 9;  // 1/s

/// A cylinder with a radius of 30 mm and a height of 40 mm that turns about its axis, without gravity.
Simulation cylinder(const std::string& models, double spacing, double viscosity, const std::string& time) {
    return simulation_of(text::time(1, time) + text::domain({-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1}, "gravity = [0, 0, 0]") +
                         "[[block]]\nshape = \"cylinder\"\nfrom = [0, 0, -0.02]\nto = [0, 0, 0.02]\nradius = 0.03\n"
                         "velocity = [\"-9*y\", \"9*x\", \"0\"]\n" +
                         text::fluid(spacing, viscosity) + models);
}

const std::string coupled = text::models("coupled"), full = text::models("ppe", "full"),
                  projection = full + "[pressure]\nform = \"projection\"\n";

/// 700 Pa s at 4 mm. @param loss of the energy in half a second, relative
void keeps_its_energy(const std::string& models, double loss, double step, double end = 0.5) {
    INFO(models << "steps of " << step << " s");
    Simulation simulation = cylinder(models, 4e-3, 700, "max_step = " + std::to_string(step) + "\n");
    const auto angular = [&] { return mean_of(simulation, [](const Vec3d& x, const Vec3d& u) { return x.cross(u).z(); }); };
    const double energy = mean_square_speed(simulation), before = angular();
    run_until(simulation, end);
    CHECK(mean_square_speed(simulation) / energy == Approx(1 - loss * end / 0.5).margin(0.004));
    CHECK(angular() == Approx(before).epsilon(1e-4));
}

/// Largest distance of a particle from where a rigid rotation would have brought it, over the radius. With 7e5 Pa s the centrifugal force
/// strains the body by less than 1e-5.
double off_its_circle(double step) {
    Simulation simulation = cylinder(full + "[viscosity]\ntolerance = 1e-6\n", 6e-3, 7e5, "fixed_step = " + std::to_string(step));
    const auto places = [&] {
        const auto x = positions(simulation);
        return std::vector<Vec3>(x.begin(), x.end());
    };
    const std::vector<Vec3> start = places();  // the store sorts its particles: identifies each by the nearest initial position
    const double end = 0.2;
    run_until(simulation, end);
    const Mat3 back = Eigen::AngleAxis<Real>(static_cast<Real>(-turning * end), Vec3::UnitZ()).toRotationMatrix();
    double worst = 0;
    for (const Vec3& x : places()) {
        double nearest = 1;
        for (const Vec3& from : start) nearest = std::min(nearest, double((back * x - from).norm()));
        worst = std::max(worst, nearest);
    }
    return worst / 0.03;
}

}  // namespace

TEST_CASE("a turning cylinder of 700 Pa s loses 1 % of its energy per second, 3 % with ppe",
          "[validation][coupled][pressure][viscosity][projection]") {
    // The centrifugal force strains the body by 0.0043/s: 0.9957 are left of a long cylinder, 0.9946 of a disc. ppe cannot pull, so its
    // fluid is not incompressible under tension: 0.9849. With steps of first order coupled has 0.934 and ppe 0.835.
    keeps_its_energy(coupled, 0.005, 5e-3, 0.25);
    keeps_its_energy(full, 0.015, 5e-3, 0.25);
    keeps_its_energy(projection, 0.005, 5e-3, 0.25);
}

TEST_CASE("a turning free cylinder of 700 Pa s keeps its energy with half and a quarter of the step",
          "[validation][coupled][pressure][viscosity][long]") {
    for (const double step : {2.5e-3, 1.25e-3}) {
        keeps_its_energy(coupled, 0.005, step);
        keeps_its_energy(full, 0.015, step);
        keeps_its_energy(projection, 0.005, step);
    }
}

TEST_CASE("a stiff body that turns follows its circle at second order in the step, with ppe and full",
          "[validation][pressure][viscosity]") {
    // A step turns the body by the angle whose sine is dt w, so it is ahead by (dt w)^2 w t/6; otherwise the motion is exact. (coupled
    // moves the particles of a lattice apart by 0.1 % of the radius first, whatever the step.)
    const double coarse = off_its_circle(8e-3), fine = off_its_circle(4e-3), order = std::log2(coarse / fine);
    INFO(coarse << " with steps of 8 ms, " << fine << " with 4 ms");
    CHECK(order > 1.8);
    CHECK(order < 2.2);
    CHECK(coarse == Approx(std::pow(8e-3 * turning, 2) * turning * 0.2 / 6).epsilon(0.15));  // measured 0.93 of it, the order 1.96
}

}  // namespace turning_body_test
