#pragma once
/// Micropolar terms of the projection: curls and Laplacians of velocity and spin that are exact for linear fields on uneven particles.
#include "engine/math/expression_field.h"
#include "engine/models/micropolar/micropolar.h"
#include "engine/models/pressure/projection/difference_sums.h"

namespace whorl {

/// The system of MicropolarOptions with the gradients G of projection_system.h and the Laplacian of corrected_viscosity.h:
///   du/dt += (mu lap u + lambda curl w)/rho,   theta dw/dt = (gamma lap w + lambda (curl u - 2 w))/rho + tau
/// At no-slip solids velocity and spin are continued behind the wall. The options for the forms of the curls do not apply, and there is no
/// central viscosity. With implicit_exchange the decay -2 lambda w is implicit.
class CorrectedMicropolar {
public:
    CorrectedMicropolar(std::shared_ptr<ProjectionSystem> system, MicropolarOptions options)
        : system_(std::move(system)), options_(std::move(options)), torque_(options_.torque) {}
    void operator()(const InteractionContext& context, StepReport& report, Read<field::role> role, Read<field::position> x,
                    Read<field::velocity> u, Update<field::acceleration> a, Write<field::spin_change> change, Update<field::spin> w);

private:
    struct Rates;
    struct Terms {
        Real nu, kappa, g;                        ///< mu, lambda and gamma, divided by the density [m^2/s, m^2/s, m^4/s]
        Real smoothing_velocity, smoothing_spin;  ///< 1/s
        Real of_layer, over_lattice;
        std::vector<char> slip;  ///< by solid
    };
    Terms terms(const InteractionContext& context) const;
    Real fastest_rate(const Terms& terms, Real spacing) const;
    template <class Kernel>
    Rates rates(const Kernel& W, const Kernel& whole, const InteractionContext& context, const Terms& terms, Index i, Span<const Vec3> u,
                Span<const Vec3> w, Span<const Vec3> of_images) const;
    template <class Kernel>
    void go_half(const Kernel& W, const Kernel& whole, const InteractionContext& context, const Terms& terms, Read<field::role> role,
                 Span<const Vec3> u, Span<const Vec3> torque, Span<const Vec3> w);
    template <class Kernel>
    EnergyWork advance(const Kernel& W, const Kernel& whole, const InteractionContext& context, const Terms& terms, Read<field::role> role,
                       Span<const Vec3> u, Update<field::acceleration> a, Write<field::spin_change> change, Span<const Vec3> w) const;

    std::shared_ptr<ProjectionSystem> system_;
    MicropolarOptions options_;
    ExpressionField torque_;
    Column<Vec3> middle_velocity_, middle_spin_;  ///< values in the middle of the step
};

/// Runs after ProjectionMove. Gives each particle the spin of its shifted position, as ProjectionShift does for the velocity.
struct CarrySpin {
    std::shared_ptr<ProjectionSystem> system;
    void operator()(const InteractionContext& context, Write<field::spin_change> change, Update<field::spin> w) const {
        const ProjectionSystem& s = *system;
        with_kernel(context.step.kernel, context.step.support, [&](const auto& W) {
            parallel_for(w.size(), [&](Index i) {
                change[i].setZero();
                if (s.shift[i] != Vec3::Zero())
                    change[i] = carried(W, s.whole, context.pairs, i, context.step.volume, w.data(), s.shift[i]);
            });
        });
        parallel_for(w.size(), [&](Index i) { w[i] += change[i]; });
    }
};

}  // namespace whorl
