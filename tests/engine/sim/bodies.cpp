/// Free bodies in whole runs: what is conserved, what is saved, what is refused.
#include "engine/io/bodies.h"

#include <catch2/catch.hpp>
#include <sstream>

#include "engine/core/parallel.h"
#include "engine/scene/read.h"
#include "engine/sim/simulation.h"
#include "tests/support/runs.h"

using namespace whorl;
using namespace whorl::test;

namespace {

/// A drop hits a tilted box and a ball, both turning, in weightlessness.
std::string collision(const std::string& models) {
    return R"toml([time]
end = 0.2
max_step = 2e-3
[domain]
min = [-0.3, -0.3, -0.3]
max = [0.3, 0.3, 0.3]
gravity = [0, 0, 0]
[fluid]
spacing = 0.0133
[[block]]
shape = "box"
min = [-0.1, -0.04, -0.04]
max = [-0.02, 0.04, 0.04]
velocity = [1, 0.1, 0]
[[solid]]
shape = "box"
min = [0.0, -0.04, -0.03]
max = [0.05, 0.05, 0.04]
density = 300
tilt = [0, 0, 12]
rotation = [1, 0, 3]
[[solid]]
shape = "sphere"
position = [0.03, 0.085, 0]
radius = 0.02
density = 2000
velocity = [0, -0.5, 0]
)toml" + models;
}

struct Momenta {
    Vec3d linear = Vec3d::Zero(), angular = Vec3d::Zero();
};

Momenta momenta(const World& world) {
    Momenta m;
    const auto x = world.fluid.column<field::position>();
    const auto u = world.fluid.column<field::velocity>();
    for (std::size_t i = 0; i < x.size(); ++i) {
        const Vec3d p = static_cast<double>(world.step.mass) * u[i].cast<double>();
        m.linear += p, m.angular += x[i].cast<double>().cross(p);
    }
    for (const Solid& solid : world.solids.all) {
        if (!solid.body) continue;
        const Vec3d p = solid.body->mass * solid.body->velocity;
        m.linear += p, m.angular += solid.body->centre.cross(p) + solid.body->spin_momentum;
    }
    return m;
}

}  // namespace

TEST_CASE(
    "fluid and bodies that collide in free space keep momentum within 1e-5 and angular momentum within 1e-6, with every model that moves "
    "them",
    "[sim][bodies]") {
    // Viscosity along the pairs, since the other Laplacian has a torque of its own. Relative to the fluid's momentum, and to that times the
    // size of the drop. In float a velocity is rounded to 6e-8 of itself at every change, a position to 3e-8 of the domain at every step,
    // the bounds are what these runs keep, with room.
    for (const std::string models : {"[models]\npressure = \"ppe\"\n",
                                     "[models]\npressure = \"ppe\"\nviscosity = \"explicit\"\n[viscosity]\nlaplacian = \"monaghan\"\n",
                                     "[models]\npressure = \"wcsph\"\nviscosity = \"explicit\"\n[viscosity]\nlaplacian = \"monaghan\"\n",
                                     "[models]\npressure = \"wcsph\"\n", "[models]\npressure = \"ppe\"\nviscosity = \"full\"\n"}) {
        std::string text = collision(models);
        if (models.find("viscosity") != std::string::npos) text.replace(text.find("spacing"), 7, "viscosity = 0.5\nspacing");
        INFO(models);
        Simulation simulation = simulation_of(text);
        const Momenta before = momenta(simulation.world());
        const Vec3d pushed = simulation.world().solids.all[0].body->velocity;
        run_until(simulation, 0.12);
        const Momenta after = momenta(simulation.world());
        const double scale = before.linear.norm();
        CHECK((after.linear - before.linear).norm() < 1e-5 * scale);
        CHECK((after.angular - before.angular).norm() < 1e-6 * scale * 0.08);
        CHECK((simulation.world().solids.all[0].body->velocity - pushed).norm() > 0.2);  // they did collide
        CHECK(simulation.totals().lost_particles == 0);
    }
}

TEST_CASE("free bodies end with the same bits on 1 and 4 threads, and in a run that was saved half-way", "[sim][bodies][resume][threads]") {
    const std::string text = collision("[models]\npressure = \"ppe\"\n");
    const int before = threads();
    set_threads(1);
    Simulation whole = simulation_of(text);
    run_until(whole, 0.1);
    std::istringstream saved(state_of(whole));
    run_until(whole, 0.2);
    set_threads(4);
    Simulation resumed = simulation_of(text);
    resumed.load(saved);
    run_until(resumed, 0.2);
    set_threads(before);
    CHECK((state_of(resumed) == state_of(whole)));
    CHECK(bodies_rows(1, 0.2, whole.world(), Vec3d::Zero()) == bodies_rows(1, 0.2, resumed.world(), Vec3d::Zero()));
}

TEST_CASE("what cannot be a free body, and models that do not move one, are told before the run", "[sim][bodies]") {
    const auto complaint = [](const std::string& text) -> std::string {
        try {
            make_plan(read_scene_text(text, "test.toml"));
            return "";
        } catch (const InputError& e) { return e.what(); }
    };
    const auto with = [](const std::string& solid, const std::string& models = "") {
        return "[time]\nend = 1\n[domain]\nmin = [-1, -1, -1]\n[fluid]\nspacing = 0.01\n" + models +
               "[[block]]\nshape = \"box\"\nmin = [0, 0, 0]\nmax = [0.1, 0.1, 0.1]\n[[solid]]\n" + solid;
    };
    const std::string ball = "shape = \"sphere\"\nradius = 0.1\nposition = [0.5, 0.5, 0.5]\n";
    CHECK(complaint(with(ball + "density = 500\n")).empty());
    CHECK_THAT(complaint(with("shape = \"plane\"\ndensity = 500\n")), Catch::Contains("plane"));
    CHECK_THAT(complaint(with(ball + "density = 500\ninside = true\n")), Catch::Contains("container"));
    CHECK_THAT(complaint(with(ball + "velocity = [1, 0, 0]\n")), Catch::Contains("has no density"));
    CHECK_THAT(complaint(with("shape = \"sphere\"\nradius = 0.1\nposition = [\"t\", 0.5, 0.5]\ndensity = 500\n")),
               Catch::Contains("depend on t"));
    CHECK_THAT(complaint(with(ball + "density = 500\n",
                              "[models]\npressure = \"ppe\"\n[pressure]\nform = \"projection\"\nsource = \"density\"\n")),
               Catch::Contains("does not move free bodies"));
    CHECK_THAT(complaint(with(ball + "density = 500\n", "[models]\nmicropolar = \"eringen\"\n")), Catch::Contains("micropolar"));
}
