#include "engine/models/viscosity/ageing_viscosity.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "engine/core/parallel.h"

namespace whorl {
namespace {

/// An age is a sum of rounded steps. By rounding it may exceed the last age with a valid viscosity; then the viscosity of a slightly
/// smaller age is used.
double viscosity_at(const Expression& f, double age, const Vec3d& x, double temperature, const StepContext& step) {
    const double value = f(age, x, temperature);
    if (is_viscosity(value)) return value;
    const double steps = age / static_cast<double>(step.dt),
                 drift = std::min(0.01, 1e-5 + steps * static_cast<double>(std::numeric_limits<Real>::epsilon()));
    for (const double before : {std::min(age, step.time), (1 - drift) * age})
        if (const double then = f(before, x, temperature); is_viscosity(then)) return then;
    return value;
}

// Sequential, because expressions are not thread-safe.
template <class PositionOf, class TemperatureOf>
void grow_older(const std::vector<Expression>& of_source, const StepContext& step, StepReport& report, Read<field::role> role,
                Read<field::position> x, Read<field::source> source, const PositionOf& place, const TemperatureOf& temperature,
                Update<field::age> age, Write<field::viscosity> mu) {
    for (Index i = 0; i < mu.size(); ++i) {
        const Expression& f = of_source[source[i]];
        const double now = static_cast<double>(age[i]);
        const double value = viscosity_at(f, now, place(i), temperature(i), step);
        if (!is_viscosity(value) && !report.diverged) {
            const std::string hot = depends_on_temperature(f) ? fmt::format(" and at {:.4g} K", temperature(i)) : "";
            report.diverged = Divergence{"ageing", "viscosity", step.time, x[i].cast<double>(),
                                         fmt::format("it is {:.4g} Pa s at the age of {:.4g} s{}", value, now, hot)};
        }
        mu[i] = static_cast<Real>(value);
        if (role[i] >= 0) age[i] += step.dt;
    }
}

Vec3d nowhere(Index) { return Vec3d::Zero(); }
double cold(Index) { return 0; }

}  // namespace

std::string allowed_instead_of(double mu) {
    if (mu < 0) return "allowed: at least 0";
    return mu > 0 ? fmt::format("allowed: up to {:.2g}", std::numeric_limits<Real>::max()) : "";
}

void AgeingViscosity::operator()(const StepContext& step, StepReport& report, Read<field::role> role, Read<field::position> x,
                                 Read<field::source> source, Update<field::age> age, Write<field::viscosity> mu) const {
    grow_older(of_source, step, report, role, x, source, nowhere, cold, age, mu);
}

void AgeingViscosityByPlace::operator()(const StepContext& step, StepReport& report, Read<field::role> role, Read<field::position> x,
                                        Read<field::source> source, Read<field::birthplace> start, Update<field::age> age,
                                        Write<field::viscosity> mu) const {
    const auto at_start = [&](Index i) { return Vec3d(start[i].cast<double>()); };
    grow_older(of_source, step, report, role, x, source, at_start, cold, age, mu);
}

void MeltingViscosity::operator()(const StepContext& step, StepReport& report, Read<field::role> role, Read<field::position> x,
                                  Read<field::source> source, Read<field::birthplace> start, Read<field::temperature> T,
                                  Update<field::age> age, Write<field::viscosity> mu) const {
    const auto at_start = [&](Index i) { return Vec3d(start[i].cast<double>()); };
    const auto now = [&](Index i) { return static_cast<double>(T[i]); };
    grow_older(of_source, step, report, role, x, source, at_start, now, age, mu);
}

}  // namespace whorl
