#pragma once
/// Viscosity that depends on a particle's age or temperature, for honey that stiffens at rest or lava that freezes.
///
/// First stage of a step, before those that read the viscosity. If no viscosity depends on age or temperature, there is no such stage and
/// no column.
#include <cmath>
#include <string>
#include <vector>

#include "engine/core/parallel.h"
#include "engine/math/expression.h"
#include "engine/models/temperature/temperature.h"
#include "engine/particles/field.h"
#include "engine/particles/step_context.h"

namespace whorl {

inline bool is_viscosity(double mu) { return mu >= 0 && std::isfinite(static_cast<Real>(mu)); }
/// Text "allowed: ..." for an invalid value; empty if mu is not a number.
std::string allowed_instead_of(double mu);

namespace field {
struct age {
    using type = Real;
    static constexpr std::string_view name = "age", unit = "s", meaning = "time since the start, or since the particle left its nozzle";
};
/// 0: in a block at the start. k > 0: from emitter k - 1.
struct source {
    using type = std::int16_t;
    static constexpr std::string_view name = "source", unit = "", meaning = "origin of the particle: 0 a block, k > 0 emitter k - 1";
};
struct birthplace {
    using type = Vec3;
    static constexpr std::string_view name = "birthplace", unit = "m", meaning = "where the particle was at the start";
};
}  // namespace field

inline bool depends_on_age(const Expression& e) { return e.variables().find('a') != std::string::npos; }
inline bool depends_on_temperature(const Expression& e) { return e.variables().find('T') != std::string::npos; }
inline bool depends_on_place(const Expression& e) { return e.variables().find_first_of("xyz") != std::string::npos; }

/// mu_i = f(age_i), with a function f for each source. Then age_i += dt, except for particles inside a nozzle. An invalid mu ends the run,
/// unless the rounding of ages causes it.
struct AgeingViscosity {
    std::vector<Expression> of_source;
    void operator()(const StepContext& step, StepReport& report, Read<field::role> role, Read<field::position> x,
                    Read<field::source> source, Update<field::age> age, Write<field::viscosity> mu) const;
};

/// AgeingViscosity with f that also depends on the position at the start.
struct AgeingViscosityByPlace {
    std::vector<Expression> of_source;
    void operator()(const StepContext& step, StepReport& report, Read<field::role> role, Read<field::position> x,
                    Read<field::source> source, Read<field::birthplace> start, Update<field::age> age, Write<field::viscosity> mu) const;
};

/// AgeingViscosity with f that also depends on the temperature, and on the position at the start.
struct MeltingViscosity {
    std::vector<Expression> of_source;
    void operator()(const StepContext& step, StepReport& report, Read<field::role> role, Read<field::position> x,
                    Read<field::source> source, Read<field::birthplace> start, Read<field::temperature> T, Update<field::age> age,
                    Write<field::viscosity> mu) const;
};

/// age_i += dt as above, for runs in which only an export needs the age.
struct AdvanceAge {
    void operator()(const StepContext& step, Read<field::role> role, Update<field::age> age) const {
        parallel_for(age.size(), [&](Index i) {
            if (role[i] >= 0) age[i] += step.dt;
        });
    }
};

}  // namespace whorl
