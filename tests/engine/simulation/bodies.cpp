/// Free bodies in whole runs: conservation, saved states, refused scenes.
#include <catch2/catch.hpp>

#include "engine/io/diagnostics.h"
#include "engine/scene/read.h"
#include "engine/simulation/simulation.h"
#include "tests/support/poured_honey.h"
#include "tests/support/runs.h"
#include "tests/support/scene_text.h"

using namespace whorl;
using namespace whorl::test;

namespace {

/// A drop hits a tilted box and a ball, both turning, in weightlessness.
std::string collision(const std::string& models, double viscosity = 0) {
    return text::time(0.2, "max_step = 2e-3") + text::domain({-0.3, -0.3, -0.3}, {0.3, 0.3, 0.3}, "gravity = [0, 0, 0]") +
           text::fluid(0.0133, viscosity) + text::block({-0.1, -0.04, -0.04}, {-0.02, 0.04, 0.04}, "velocity = [1, 0.1, 0]") +
           text::box({0, -0.04, -0.03}, {0.05, 0.05, 0.04}, "density = 300\ntilt = [0, 0, 12]\nrotation = [1, 0, 3]") +
           text::ball({0.03, 0.085, 0}, 0.02, "density = 2000\nvelocity = [0, -0.5, 0]") + models;
}

struct Momenta {
    Vec3d linear = Vec3d::Zero(), angular = Vec3d::Zero();
};

Momenta momenta(const World& world) {
    const Measures fluid = measure(world, Vec3d::Zero(), 1);
    Momenta m{fluid.momentum, fluid.angular_momentum};
    for (const Solid& solid : world.solids.all) {
        if (!solid.body) continue;
        const Vec3d p = solid.body->mass * solid.body->velocity;
        m.linear += p, m.angular += solid.body->centre.cross(p) + solid.body->spin_momentum;
    }
    return m;
}

}  // namespace

TEST_CASE("fluid and bodies that collide keep momentum within 1e-5, angular momentum within 1e-6", "[sim][bodies]") {
    // Viscosity along the pairs, because the other Laplacian exerts a torque. Relative to the fluid's momentum, and to that times the
    // size of the drop. In float a velocity is rounded to 6e-8 of itself at every change, a position to 3e-8 of the domain at every step.
    // The bounds are those of these runs, with a margin.
    const std::string along_pairs = "[viscosity]\nlaplacian = \"monaghan\"\n";
    for (const std::string& models :
         {text::models("ppe"), text::models("ppe", "explicit") + along_pairs, text::models("wcsph", "explicit") + along_pairs,
          text::models("wcsph"), text::models("ppe", "full")}) {
        const std::string text = collision(models, models.find("viscosity") != std::string::npos ? 0.5 : 0);
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

TEST_CASE("free bodies are bit-identical on 1 and 4 threads and after a resume", "[sim][bodies][resume][threads]") {
    CHECK(differing_bits(collision(text::models("ppe")), 0.2) == "");
}

namespace {

/// Still water in an open box, 30 by 10 particles or 10 by 8 by 8, in which bodies lie.
std::string pond(bool plane, const std::string& models, const std::string& bodies) {
    const int dimensions = plane ? 2 : 3;
    const double x = plane ? 0.15 : 0.05, z = 0.04;
    const text::Point low = text::point(dimensions, -x, 0, -z);
    return text::time(20, "max_step = 5e-3") +
           text::domain(text::point(dimensions, -0.2, -0.02, -0.1), text::point(dimensions, 0.2, 0.3, 0.1)) + text::fluid(0.01) + models +
           text::block(low, text::point(dimensions, x, plane ? 0.1 : 0.08, z)) + text::tank(low, text::point(dimensions, x, 0.2, z)) +
           bodies;
}
std::string lying(const text::Point& min, const text::Point& max, double density) {
    return text::box(min, max, "density = " + std::to_string(density));
}

/// Motion in a scene that should stay at rest.
struct Unrest {
    double density_error = 0;     ///< largest mean
    double moved = 0, speed = 0;  ///< largest displacement of a body, and its speed at the end [m, m/s]
    double energy = 0;            ///< kinetic energy at the end, over the water's potential energy above the floor
};
Unrest unrest(const std::string& text, double seconds) {
    Simulation simulation = simulation_of(text);
    const World& world = simulation.world();
    std::vector<Vec3d> start;
    for (const Solid& solid : world.solids.all)
        if (solid.body) start.push_back(solid.body->centre);
    Unrest found;
    while (simulation.time() < seconds) {
        run_until(simulation, simulation.time() + 0.1);
        const Measures now = measure(world, Vec3d(0, -9.81, 0), 1);
        found.density_error = std::max(found.density_error, now.density_error_mean);
        found.energy = now.kinetic_energy;
        found.speed = 0;
        auto from = start.begin();
        for (const Solid& solid : world.solids.all) {
            if (!solid.body) continue;
            found.moved = std::max(found.moved, (solid.body->centre - *from++).norm());
            found.speed = std::max(found.speed, solid.body->velocity.norm());
            found.energy += solid.body->kinetic_energy();
        }
        found.energy /= now.potential_energy;
    }
    return found;
}

}  // namespace

TEST_CASE("bodies on the bottom of still water stay at rest: alone, stacked, side by side, in 2D and 3D", "[sim][bodies]") {
    // The lattice melts meanwhile, as it does around a fixed box: there kinetic energy is .04 to .16 % of the potential energy within the
    // first second.
    const std::string stone = lying({-0.04, 0}, {0.04, 0.04}, 2000);
    for (const std::string& text :
         {pond(true, "", stone), pond(true, "", lying({-0.04, 0}, {0.04, 0.04}, 1200)),
          pond(true, "",
               lying({-0.04, 0}, {0.04, 0.02}, 2000) + lying({-0.03, 0.02}, {0.03, 0.04}, 3000) + lying({-0.02, 0.04}, {0.02, 0.07}, 1500)),
          pond(true, "", lying({-0.05, 0}, {0, 0.04}, 2000) + lying({0, 0}, {0.04, 0.03}, 2500)),
          pond(false, "", lying({-0.02, 0, -0.02}, {0.02, 0.03, 0.02}, 2000))}) {
        INFO(text);
        const Unrest found = unrest(text, 0.3);
        CHECK(found.density_error < 1e-3);
        CHECK(found.energy < 2e-3);
        CHECK(found.moved < 1e-5);
        CHECK(found.speed < 1e-4);
    }
}

TEST_CASE("a body that lies on the bottom of weakly compressible water stays there", "[sim][bodies]") {
    // The water calms down equally with any share of XSPH: after .3 s kinetic energy is 4 to 6e-5 of the potential energy.
    for (const std::string smoothing : {"", "viscosity = \"xsph\"\n", "viscosity = \"xsph\"\n[viscosity]\nalpha = 0.02\n"}) {
        INFO(smoothing);
        const Unrest found = unrest(pond(true, "[models]\npressure = \"wcsph\"\n" + smoothing, lying({-0.04, 0}, {0.04, 0.04}, 2000)), 0.3);
        CHECK(found.density_error < 1e-2);  // its pressure is one
        CHECK(found.energy < 2e-4);
        CHECK(found.moved < 1e-5);
        CHECK(found.speed < 1e-4);
    }
}

TEST_CASE("invalid free bodies, and models that cannot move one, are refused before the run", "[sim][bodies]") {
    const auto complaint = [](const std::string& text) { return messages_with({}, text); };
    const auto with = [](const std::string& solid, const std::string& models = "") {
        return "[time]\nend = 1\n[domain]\nmin = [-1, -1, -1]\n[fluid]\nspacing = 0.01\n" + models +
               "[[block]]\nshape = \"box\"\nmin = [0, 0, 0]\nmax = [0.1, 0.1, 0.1]\n[[solid]]\n" + solid;
    };
    const std::string ball = "shape = \"sphere\"\nradius = 0.1\nposition = [0.5, 0.5, 0.5]\n";
    CHECK(complaint(with(ball + "density = 500\n")) == "no error");
    CHECK_THAT(complaint(with("shape = \"plane\"\ndensity = 500\n")), Catch::Contains("plane"));
    CHECK_THAT(complaint(with(ball + "density = 500\ncontainer = true\n")), Catch::Contains("container"));
    CHECK_THAT(complaint(with(ball + "velocity = [1, 0, 0]\n")), Catch::Contains("has no density"));
    CHECK_THAT(complaint(with("shape = \"sphere\"\nradius = 0.1\nposition = [\"t\", 0.5, 0.5]\ndensity = 500\n")),
               Catch::Contains("depends on t"));
    CHECK_THAT(complaint(with(ball + "density = 500\n",
                              "[models]\npressure = \"ppe\"\n[pressure]\nform = \"projection\"\nsource = \"density\"\n")),
               Catch::Contains("does not move free bodies"));
    CHECK_THAT(complaint(with(ball + "density = 500\n", "[models]\nmicropolar = \"eringen\"\n")), Catch::Contains("micropolar"));
}
