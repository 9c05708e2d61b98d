/// Free bodies in the projection, against Archimedes and added masses.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/support/runs.h"

using namespace whorl;
using namespace whorl::test;

namespace projection_bodies_test {

namespace {

const RigidBody& body_of(const Simulation& simulation) { return *simulation.world().solids.all.back().body; }

/// A body, a disc or a ball of five spacings, in the middle of a round vessel full of water, three times as wide.
std::string vessel(int dimensions, double density) {
    const std::string low = dimensions == 2 ? "[-0.2, -0.2]" : "[-0.2, -0.2, -0.2]",
                      high = dimensions == 2 ? "[0.2, 0.2]" : "[0.2, 0.2, 0.2]";
    return fmt::format(R"toml([time]
end = 1
max_step = 2e-3
[domain]
dimensions = {}
min = {}
max = {}
[fluid]
spacing = 0.01
[pressure]
form = "projection"
[[block]]
shape = "sphere"
radius = 0.15
[[solid]]
shape = "sphere"
inside = true
radius = 0.15
[[solid]]
shape = "sphere"
radius = 0.05
density = {}
)toml",
                       dimensions, low, high, density);
}

/// Of the acceleration from rest (m_f - m) g/(m + C m_f), C = (b^2 + a^2)/(b^2 - a^2) or (b^3 + 2 a^3)/(b^3 - a^3)/2 in a vessel of radius
/// b about a body of radius a.
double part_of_acceleration(int dimensions, double density, double time) {
    const double b = std::pow(3.0, dimensions), C = dimensions == 2 ? (b + 1) / (b - 1) : (b + 2) / (b - 1) / 2;
    Simulation simulation = simulation_of(vessel(dimensions, density));
    run_until(simulation, time);
    return body_of(simulation).velocity.y() / time / ((1000 - density) / (density + C * 1000) * 9.81);
}

}  // namespace

}  // namespace projection_bodies_test
