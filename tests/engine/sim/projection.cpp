/// The stages of the projection together: the same bits, walls that move, what is kept and what is not.
#include <catch2/catch.hpp>
#include <cmath>
#include <sstream>

#include "engine/core/parallel.h"
#include "tests/support/runs.h"

using namespace whorl;
using namespace whorl::test;

namespace projection_test {

namespace {

/// A tank with a free surface in which a wall moves, in the plane.
const std::string tank = R"toml([time]
end = 1
[domain]
dimensions = 2
min = [-0.05, -0.05]
max = [0.25, 0.3]
[fluid]
spacing = 0.01
viscosity = 0.5
[models]
pressure = "ppe"
[pressure]
form = "projection"
[[block]]
shape = "box"
min = [0, 0]
max = [0.2, 0.15]
sampling = "jittered"
[[solid]]
shape = "box"
inside = true
min = [0, 0]
max = [0.2, 0.3]
[[solid]]
shape = "box"
min = [0.08, 0.03]
max = [0.12, 0.06]
position = ["0.01*sin(10*t)", "0"]
)toml";

/// Vortices in a periodic box, off their lattice, in a stream.
const std::string vortices = R"toml([time]
end = 1
[domain]
dimensions = 2
max = [1, 1]
periodic = [true, true]
gravity = [0, 0]
min = [0, 0]
[fluid]
spacing = 0.0625
density = 1
viscosity = 0.01
[models]
viscosity = "explicit"
[[block]]
shape = "box"
min = [0, 0]
max = [1, 1]
sampling = "jittered"
velocity = ["STREAM + sin(2*pi*x)*cos(2*pi*y)", "-cos(2*pi*x)*sin(2*pi*y)"]
)toml";

std::string in_stream(const char* speed) {
    std::string text = vortices;
    return text.replace(text.find("STREAM"), 6, speed);
}

Vec3d momentum(const Simulation& simulation) {
    Vec3d sum = Vec3d::Zero();
    for (const Vec3& u : simulation.world().fluid.column<field::velocity>()) sum += u.cast<double>();
    return sum / static_cast<double>(simulation.world().fluid.size());
}

/// Of the motion relative to the mean, over all particles.
double energy(const Simulation& simulation) {
    const Vec3d mean = momentum(simulation);
    double sum = 0;
    for (const Vec3& u : simulation.world().fluid.column<field::velocity>()) sum += (u.cast<double>() - mean).squaredNorm();
    return sum / static_cast<double>(simulation.world().fluid.size());
}

}  // namespace

TEST_CASE("the projection has the same bits on 1, 2 and 4 threads, and in a run that was saved half-way",
          "[sim][projection][threads][resume]") {
    const int before = threads();
    std::string first;
    for (const int count : {1, 2, 4}) {
        set_threads(count);
        Simulation simulation = simulation_of(tank);
        run_until(simulation, 0.05);
        run_until(simulation, 0.1);
        if (count == 1) first = state_of(simulation);
        INFO(count << " threads");
        CHECK(state_of(simulation) == first);
    }
    set_threads(before);
    Simulation half = simulation_of(tank);
    run_until(half, 0.05);
    std::istringstream saved(state_of(half));
    Simulation resumed = simulation_of(tank);
    resumed.load(saved);
    run_until(resumed, 0.1);
    CHECK((state_of(resumed) == first));
    CHECK(resumed.totals().lost_particles == 0);
}

TEST_CASE("a box full of fluid takes the projection by itself, and a stream carries its vortices unchanged", "[sim][projection]") {
    // Galilean invariance: what the stream changes is where the particles' noise is when, at 16 a side 2 % of the energy in .5 s.
    Simulation still = simulation_of(in_stream("0")), carried = simulation_of(in_stream("0.5"));
    CHECK(still.plan().facts.pressure.form == PressureForm::projection);
    const double start = energy(still);
    run_until(still, 0.5);
    run_until(carried, 0.5);
    CHECK(energy(carried) == Approx(energy(still)).epsilon(0.02));
    // The gradients are not pairwise opposite: momentum drifts by less than 3e-3 of that of the vortices.
    CHECK(momentum(still).norm() < 3e-3 * std::sqrt(start));
    CHECK((momentum(carried) - Vec3d(0.5, 0, 0)).norm() < 3e-3 * std::sqrt(start));
}

}  // namespace projection_test
