#pragma once
/// Small displacements against the gradient of the particles' concentration. They keep particles evenly distributed in flows that would
/// draw them into lines and leave holes (Lind, Xu, Stansby and Rogers 2012; pair weight after Monaghan 2000).
///
///   x_i -= dt s_i R (sum_j V [1 + 0.2 (W_ij/W(d))^4] grad W_ij + sum_s V_s grad W_is),    s_i = max_j |u_i - u_j|
///
/// s_i is the same in every frame of reference that moves at constant velocity. The displacement is at most a twentieth of a spacing. It
/// fades out at a free surface, as the density falls from 0.95 to 0.9 rho_0, or as |sum of gradients| rises from 0.8/R to 1.2/R. (At a flat
/// surface these are 0.85 rho_0 and 1.3/R.) Velocities do not change, so momentum is conserved exactly.
///
/// This stage runs after the forces and before Move. It needs neighbours and density.
#include "engine/core/parallel.h"
#include "engine/particles/field.h"
#include "engine/particles/interaction_context.h"
#include "engine/sph/gate.h"

namespace whorl {

namespace field {
struct shift {
    using type = Vec3;
    static constexpr std::string_view name = "shift", unit = "m", meaning = "displacement that evens out the particles";
};
}  // namespace field

/// Shortens the rising parts of displacements dx until all displacements together do no work against gravity, sum g.dx >= 0. Displacements
/// away from walls and below a free surface are not balanced by opposite ones. They would lift the fluid in each step, and the fluid would
/// sink again by its velocity.
inline void lift_nothing(const Vec3& gravity, Span<Vec3> moves) {
    const auto sum_of = [&](double sign) {
        return parallel_sum(static_cast<Index>(moves.size()),
                            [&](Index i) { return std::max(0.0, sign * static_cast<double>(gravity.dot(moves[i]))); });
    };
    const double risen = sum_of(-1), sunk = sum_of(1);
    if (!(risen > sunk)) return;
    const Vec3 too_much = static_cast<Real>((1 - sunk / risen) / gravity.cast<double>().squaredNorm()) * gravity;
    parallel_for(static_cast<Index>(moves.size()), [&](Index i) { moves[i] -= std::min(Real(0), gravity.dot(moves[i])) * too_much; });
}

struct FickianShift {
    Real solid_factor = 1;  ///< factor on the volumes of boundary particles, see models/boundary/wall.h
    SolidGate gate = {};
    void operator()(const InteractionContext& context, Read<field::role> role, Read<field::density> rho, Read<field::velocity> u,
                    Write<field::shift> shift, Update<field::position> x) const;
};

}  // namespace whorl
