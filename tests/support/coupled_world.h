#pragma once
/// A free-standing world for tests of the coupled solve: particles, its five stages, no scene.
#include "engine/core/clock.h"
#include "engine/models/viscosity/coupled/coupled_solve.h"
#include "engine/simulation/stage.h"

namespace whorl::test {

struct CoupledWorld {
    World world;
    std::shared_ptr<CoupledSystem> system;
    std::vector<Stage> stages;

    /// @param spacing d [m] @param nu kinematic viscosity [m^2/s]; the density is 1000 kg/m^3
    CoupledWorld(const std::vector<Vec3>& x, Real spacing, Real nu, CoupledOptions options = {});

    Span<Vec3> position() { return world.fluid.column<field::position>(); }
    Span<Vec3> velocity() { return world.fluid.column<field::velocity>(); }
    Span<std::int16_t> role() { return world.fluid.column<field::role>(); }
    /// Adds particles at rest. @return index of the first
    Index add(const std::vector<Vec3>& x);
    /// One step of dt [s]; false if the solve did not converge.
    bool step(Real dt, bool at_frame_time = false);
    /// A step without move, shift and contact.
    bool solve_only(Real dt);
    const SolveReport& last_solve() const { return world.report.solves.back().report; }
    double time = 0, seconds = 0;  ///< simulated time; wall time spent in stages [s]
    StageTimes times;

private:
    Real viscosity_;
    void run(std::size_t stages, Real dt, bool at_frame_time);
};

/// Blue noise in a cylinder along y from y = 0 to y = length, periodic along it. Deterministic.
std::vector<Vec3> blue_noise_cylinder(Real radius, Real length, Real spacing, unsigned seed = 1);

/// Longest link of the minimum spanning tree of all points: the size of the widest gap.
double longest_link(const std::vector<Vec3d>& x);

}  // namespace whorl::test
