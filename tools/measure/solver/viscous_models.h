#pragma once
/// The viscous models as linear maps from velocities to viscous accelerations, for tables that compare them.
#include <functional>
#include <string>

#include "tests/support/world.h"

namespace whorl {

struct ViscousModel {
    std::string name;
    bool implicit = false;
    double support = 2;  ///< kernel radius over spacing that it is meant for
    /// The viscous acceleration [m/s^2] of the world's velocities, pairs found, density and viscosity set.
    std::function<std::vector<Vec3>(test::TestWorld&)> acceleration;
    /// The stage that steps it, and the stage that must run before; empty for none.
    std::function<std::vector<Stage>(double tolerance)> stages;
};

/// xsph, explicit (two Laplacians), full_assembled, full.
std::vector<ViscousModel> viscous_models();

/// A free body of particles at x with viscosity mu [Pa s], neighbours and density found.
test::TestWorld body(const std::vector<Vec3>& x, double spacing, double support, double mu, const std::vector<Stage>& stages = {});

/// A cylinder along x of blue noise, its middle at the origin [m].
std::vector<Vec3> rope(double radius, double length, double spacing);

}  // namespace whorl
