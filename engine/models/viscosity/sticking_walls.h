#pragma once
/// Solids that the fluid sticks to, as neighbours in the viscous operator.
#include <limits>

#include "engine/models/boundary/wall.h"
#include "engine/models/viscosity/viscous_operator.h"

namespace whorl {

template <class Kernel>
class StickingWalls {
public:
    StickingWalls(const Kernel& kernel, const Surroundings& around, const ViscosityOptions& options)
        : kernel_(kernel), around_(around), options_(options), slip_(slips(around.solids)) {}
    /// On the solids' volumes at particle i, with the gate's weight.
    Real factor(Index i) const {
        return options_.solid_factor * options_.gate.weight(kernel_, i, around_.solid_pairs, around_.layer.volume, options_.solid_factor);
    }
    const Solid& solid(Index s) const { return around_.solids.all[around_.layer.solid[s]]; }
    /// w = V |W'|/r of particle s of the layer; 0 where the fluid slips.
    Real weight(Real factor, Index s, Real distance) const {
        if (slip_[around_.layer.solid[s]]) return 0;
        return -factor * around_.layer.volume[s] * kernel_.derivative(distance) / std::max(distance, std::numeric_limits<Real>::min());
    }
    Real stretch(Index s, const Vec3& r) const {
        return options_.stretches() ? WallShear{around_.step.spacing / 2}.stretch(r, around_.layer.normal[s]) : 1;
    }
    /// V with  stretch u_i - V = stretch (u_i - u_wall(x_i)) + (u_wall(x_i) - u_wall(x_s)),  u_wall the rigid motion of the solid in the
    /// step's middle [m/s].
    Vec3 velocity(Index s, const Vec3& r, Real stretch) const {
        const Pose& pose = solid(s).pose;
        const Vec3 x = around_.layer.position[s];
        return (stretch - 1) * pose.velocity_over(around_.step.dt, x + r) + pose.velocity_over(around_.step.dt, x);
    }

private:
    const Kernel& kernel_;
    const Surroundings& around_;
    const ViscosityOptions& options_;
    std::vector<char> slip_;
};

}  // namespace whorl
