#pragma once
/// Implicit viscosity in its full form, variational and matrix-free (viscous_operator.h).
///
/// Stages of a step, in order: VelocityGradient, Gravity, (forces), Kick, FullViscosity, (pressure), Move. The corrected form needs no
/// density.
#include "engine/models/viscosity/flow_law.h"
#include "engine/models/viscosity/strain/curvature.h"
#include "engine/models/viscosity/viscous_operator.h"

namespace whorl {

namespace field {
struct viscous_aggregate {
    using type = std::int32_t;
    static constexpr std::string_view name = "viscous_aggregate", unit = "",
                                      meaning = "rigid group in the coarse level of the viscosity, 0: none";
};
}  // namespace field

/// Stage of the corrected form: u = argmin E.
class FullViscosity {
public:
    explicit FullViscosity(ViscosityOptions options) : options_(options) {}
    void operator()(const InteractionContext& context, StepReport& report, Read<field::role> role, Read<field::position> x,
                    Read<field::viscosity> mu, Read<field::velocity_gradient> before, Update<field::velocity> u,
                    Update<field::viscous_acceleration> last, Update<field::viscous_aggregate> aggregate);

protected:
    /// @param changed the viscosities differ from those of the last call: the coarse level is factored again
    void set_up_coarse(const FluidPairs& pairs, const StepContext& step, Read<field::role> role, Read<field::position> x,
                       Span<std::int32_t> aggregate, bool changed = false);
    ViscosityOptions options_;
    ViscousOperator operator_;
    CoarseLevel coarse_;
};

/// The same for a fluid whose viscosity depends on the strain rate. field::viscosity is K of the law.
class YieldingViscosity : private FullViscosity {
public:
    YieldingViscosity(ViscosityOptions options, const FlowLaw& law) : FullViscosity(options), law_(law) {}
    void operator()(const InteractionContext& context, StepReport& report, Read<field::role> role, Read<field::position> x,
                    Read<field::viscosity> K, Read<field::velocity_gradient> before, Update<field::velocity> u,
                    Update<field::viscous_acceleration> last, Update<field::viscous_aggregate> aggregate, Update<field::shear_rate> gamma,
                    Write<field::apparent_viscosity> mu);

private:
    FlowLaw law_;
};

/// Stage of the uncorrected form, whose weights contain the density.
class UncorrectedViscosity {
public:
    explicit UncorrectedViscosity(ViscosityOptions options) : options_(options) { options_.correction = false; }
    void operator()(const InteractionContext& context, StepReport& report, Read<field::role> role, Read<field::position> x,
                    Read<field::density> rho, Read<field::viscosity> mu, Read<field::velocity_gradient> before, Update<field::velocity> u,
                    Update<field::viscous_acceleration> last) {
        operator_.set_up(options_, context, role, mu, rho.values, before.values);
        solve_implicit(operator_, options_.limits, {context, report, role, x, u, last});
    }

private:
    ViscosityOptions options_;
    ViscousOperator operator_;
};

}  // namespace whorl
