#pragma once
/// Damping of motion that the particles cannot resolve.
#include "engine/core/column.h"
#include "engine/particles/field.h"
#include "engine/particles/interaction_context.h"

namespace whorl {

/// u_i += D c sum_j V W_ij (e_ij.r_ij) r_ij/|r_ij|^2,   e_ij = u_j - u_i - (G_i + G_j)/2 (x_j - x_i),   c = rate dt, at most 0.3
/// with D the number of dimensions and G the local velocity gradient (least squares; 0 if the neighbours do not span all directions).
///
/// Particles settle from a loose packing into a denser one. In an inviscid fluid the energy that this releases persists as relative motion
/// of neighbours. A linear flow has e = 0 and is not damped. Forces act along the pairs, so momentum and angular momentum are conserved.
/// `rate` is given in units of sqrt(g/d + sigma/(rho d^3)), the inverse of the time in which gravity and surface tension move a particle by
/// a spacing. Without gravity and surface tension there is no damping.
class DampUnresolved {
public:
    /// @param tension surface tension [N/m]
    explicit DampUnresolved(double rate, double tension = 0) : rate_(rate), tension_(tension) {}
    void operator()(const InteractionContext& context, Read<field::role> role, Update<field::velocity> u);

private:
    /// Symmetric part of the velocity's gradient: the diagonal, and twice the other entries [1/s].
    struct Stretching {
        Column<Vec3> along, across;
    };
    static constexpr Index most = Pairs::Group::most;
    template <class Kernel>
    static Stretching find_gradients(const Kernel& W, const FluidPairs& pairs, const StepContext& step, Update<field::velocity> u);
    /// @returns the changes of the velocities [m/s]
    template <class Kernel>
    static Column<Vec3> find_changes(const Kernel& W, const FluidPairs& pairs, const StepContext& step, Update<field::velocity> u,
                                     const Stretching& stretching, Real c);

    double rate_, tension_;
};

}  // namespace whorl
