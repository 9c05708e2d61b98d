#pragma once
/// A world for tests of single models: fluid on a lattice, flat walls of one layer, and a loop over stages, without a scene.
#include <functional>
#include <vector>

#include "engine/particles/search.h"
#include "engine/simulation/stage.h"

namespace whorl::test {

struct TestWorld {
    World world;
    std::vector<Stage> stages;
    NeighbourSearch search, solid_search;

    /// @param spacing d [m] @param support kernel radius over d @param domain a domain without depth makes the flow 2D
    TestWorld(double spacing, double support, const Domain& domain, KernelKind kernel = KernelKind::cubic);

    /// Stages to run in a step, in order; allocates their fields. Call before placing fluid.
    void use(std::vector<Stage> all);
    /// Lattice of fluid whose cells fill the box, with the velocity u(x) and viscosity mu [Pa s].
    void place(const Vec3& min, const Vec3& max, double mu = 0, const std::function<Vec3(const Vec3&)>& u = {});
    /// Fluid of these particles at rest, in place of what there is.
    void put(const std::vector<Vec3>& x);
    /// A flat wall that covers the domain: the solid lies on the side that the normal points away from; one layer half a spacing inside.
    /// axis: 0, 1, 2; side: +1 where the normal is +axis.
    void add_wall(int axis, int side, double at, double slip_length = 0);
    /// Velocity of a wall along itself [m/s]; its particles stay where they are.
    void move_wall(Index wall, const Vec3& velocity);

    /// Neighbours at the current positions.
    void find_pairs();
    void step(double dt);

    template <class F>
    Span<typename F::type> column() {
        return world.fluid.template column<F>();
    }
    Vec3d momentum();          ///< kg m/s
    Vec3d angular_momentum();  ///< kg m^2/s about the origin
    double max_speed();
};

}  // namespace whorl::test
