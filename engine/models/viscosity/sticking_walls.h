#pragma once
/// No-slip solids as neighbours in the viscous operator.
#include <limits>

#include "engine/models/boundary/wall.h"
#include "engine/models/viscosity/viscous_operator.h"

namespace whorl {

template <class Kernel>
class StickingWalls {
public:
    StickingWalls(const Kernel& kernel, const InteractionContext& context, const ViscosityOptions& options)
        : kernel_(kernel), context_(context), options_(options), slip_(slips(context.solids)) {}
    /// Factor on the volumes of boundary particles near particle i, including the gate's weight.
    Real factor(Index i) const {
        return options_.solid_factor *
               options_.gate.weight(kernel_, i, context_.solid_pairs, context_.boundary.volume, options_.solid_factor);
    }
    const Solid& solid(Index s) const { return context_.solids.all[context_.boundary.solid[s]]; }
    /// w = V |W'|/r of boundary particle s; 0 if the fluid slips on its solid.
    Real weight(Real factor, Index s, Real distance) const {
        if (slip_[context_.boundary.solid[s]]) return 0;
        return -factor * context_.boundary.volume[s] * kernel_.derivative(distance) / std::max(distance, std::numeric_limits<Real>::min());
    }
    Real stretch(Index s, const Vec3& r) const {
        return options_.stretches() ? WallShear{context_.step.spacing / 2}.stretch(r, context_.boundary.normal[s]) : 1;
    }
    /// Velocity v_s of boundary particle s in the sums [m/s], such that
    ///   stretch u_i - v_s = stretch (u_i - u_wall(x_i)) + (u_wall(x_i) - u_wall(x_s)),
    /// with u_wall the rigid motion of the solid in the middle of the step.
    Vec3 velocity(Index s, const Vec3& r, Real stretch) const {
        const Pose& pose = solid(s).pose;
        const Vec3 x = context_.boundary.position[s];
        return (stretch - 1) * pose.velocity_over(context_.step.dt, x + r) + pose.velocity_over(context_.step.dt, x);
    }

private:
    const Kernel& kernel_;
    const InteractionContext& context_;
    const ViscosityOptions& options_;
    std::vector<char> slip_;
};

}  // namespace whorl
