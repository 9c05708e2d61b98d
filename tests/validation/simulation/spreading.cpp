/// A puddle of syrup on a plate against the similarity solution of the viscous gravity current (Huppert 1982).
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "tests/support/runs.h"

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
    std::string text = fmt::format(R"toml([time]
end = 100
[domain]
min = [-0.1, -0.02, -0.1]
max = [0.1, 0.05, 0.1]
[fluid]
spacing = {}
viscosity = {}
{}
)toml",
                                   d, 1000 * nu, rest);
    for (int layer = 0; layer * d < height - d / 2; ++layer)
        text += fmt::format("[[block]]\nshape = \"cylinder\"\nfrom = [0, {}, 0]\nto = [0, {}, 0]\nradius = {}\nsampling = \"blue_noise\"\n",
                            layer * d, (layer + 1) * d, radius * std::sqrt(1 - std::pow((layer + 0.5) * d / height, 3)));
    return text;
}

const std::string sticking = "[[solid]]\nshape = \"plane\"\n";

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
    double square = 0, front = 0;
    for (const Vec3& p : simulation.world().fluid.column<field::position>()) {
        const double s = p[0] * p[0] + p[2] * p[2];
        square += s, front = std::max(front, std::sqrt(s));
    }
    const double radius = std::sqrt(7.0 / 3 * square / count), theory = current.radius(start + simulation.time());
    CAPTURE(radius / d, theory / d, front / d);
    CHECK(radius == Approx(theory).epsilon(0.02));
    CHECK(front + d / 2 == Approx(theory).epsilon(0.05));
}

}  // namespace

TEST_CASE("a puddle on a plate spreads as t^(1/8) within 2 %, from six layers of particles to five", "[validation][sim][spreading][long]") {
    spreads("[models]\npressure = \"ppe\"\nviscosity = \"full\"\n" + sticking);
}

TEST_CASE("a puddle on a plate spreads as t^(1/8) within 2 % with the coupled solve", "[validation][sim][spreading][long]") {
    spreads("[models]\npressure = \"coupled\"\n" + sticking);
}

}  // namespace spreading_test
