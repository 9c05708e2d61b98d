/// A puddle of syrup on a plate against the similarity solution of the viscous gravity current (Huppert 1982).
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "tests/support/runs.h"
#include "tests/support/scene_text.h"

using namespace whorl;
using namespace whorl::test;

namespace spreading_test {

namespace {

constexpr double d = 1e-3, g = 9.81, nu = 2e-3, pi = std::numbers::pi;

/// h(r, t) = 4/3 V/(pi R^2) (1 - r^2/R^2)^(1/3), R(t) = 0.894 (g V^3/(3 nu))^(1/8) t^(1/8), with the 0.894 from the volume.
struct Current {
    double volume;
    double scale() const { return std::pow(1024 / (81 * pi * pi * pi) * g * volume * volume * volume / (3 * nu), 0.125); }
    double radius(double time) const { return scale() * std::pow(time, 0.125); }
    double time(double radius) const { return std::pow(radius / scale(), 8); }
};

/// The profile in layers of one spacing, of this radius and height.
std::string puddle(double radius, double height, const std::string& rest) {
    std::string scene = text::time(100) + text::domain({-0.1, -0.02, -0.1}, {0.1, 0.05, 0.1}) + text::fluid(d, 1000 * nu) + rest;
    for (int layer = 0; layer * d < height - d / 2; ++layer)
        scene +=
            fmt::format("[[block]]\nshape = \"cylinder\"\nfrom = [0, {}, 0]\nto = [0, {}, 0]\nradius = {}\nsampling = \"blue_noise\"\n",
                        layer * d, (layer + 1) * d, radius * std::sqrt(1 - std::pow((layer + 0.5) * d / height, 3)));
    return scene;
}

void spreads(const std::string& models) {
    // It starts with the profile of the similarity solution and takes twice the time that a point source would have taken: a
    // viscosity that is wrong by a half shows. The radius is that of a similarity profile with the same mean square distance from the axis:
    // at the front, an uncertainty of half a spacing is 2 %.
    INFO(models);
    Simulation simulation = simulation_of(puddle(24 * d, 6 * d, models));
    const auto count = static_cast<double>(simulation.world().fluid.size());
    const Current current{count * d * d * d};
    const double start = current.time(24 * d);
    run_until(simulation, start);
    double front = 0;
    for (const Vec3& p : positions(simulation)) front = std::max(front, std::hypot(double(p[0]), double(p[2])));
    const double square = mean_of(simulation, [](const Vec3d& x, const Vec3d&) { return x[0] * x[0] + x[2] * x[2]; });
    const double radius = std::sqrt(7.0 / 3 * square), theory = current.radius(start + simulation.time());
    CAPTURE(radius / d, theory / d, front / d);
    CHECK(radius == Approx(theory).epsilon(0.02));
    CHECK(front + d / 2 == Approx(theory).epsilon(0.05));
}

}  // namespace

TEST_CASE("a puddle spreads as t^(1/8) within 2 %, from six layers of particles to five, with ppe and coupled",
          "[validation][sim][spreading][long]") {
    for (const std::string& models : {text::models("ppe", "full"), text::models("coupled")})
        spreads(models + text::plane({0, 0, 0}, {0, 1, 0}));
}

}  // namespace spreading_test
