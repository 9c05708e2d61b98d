#include <catch2/catch.hpp>

#include "engine/simulation/initial_state.h"
#include "tests/support/world.h"

using namespace whorl;

TEST_CASE("a nozzle opens the fixed wall that it passes, and no other", "[particles][boundary]") {
    const Real d = Real(0.01);
    test::TestWorld w(0.01, 2, Domain{Vec3::Constant(Real(-0.2)), Vec3::Constant(Real(0.2)), {}});
    w.add_wall(1, +1, 0);
    w.add_wall(1, -1, 0.15);
    EmitterShape shape;
    shape.centre = Vec3::Zero(), shape.direction = Vec3::UnitY(), shape.radius = 4 * d;
    std::vector<Emitter> nozzle;
    nozzle.emplace_back(shape, Expression(1.0), 0, 1, d, 4 * d, 1, 7);
    BoundaryParticles& boundary = w.world.boundary_particles;
    const Index before = boundary.size();
    open_walls(nozzle, w.world);
    CHECK(before - boundary.size() == Approx(16 * M_PI).margin(25));  // the opening and the pipe's own wall
    for (const Vec3& x : boundary.position) REQUIRE(nozzle[0].distance(x) >= 0);
}
