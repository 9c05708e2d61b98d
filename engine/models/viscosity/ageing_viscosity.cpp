#include "engine/models/viscosity/ageing_viscosity.h"

#include <fmt/format.h>

#include "engine/core/parallel.h"

namespace whorl {
namespace {

// One after the other: expressions are not thread-safe.
template <class Place>
void grow_older(const std::vector<Expression>& of_source, const StepContext& step, StepReport& report, Read<field::role> role,
                Read<field::position> x, Read<field::source> source, const Place& place, Update<field::age> age,
                Write<field::viscosity> mu) {
    for (Index i = 0; i < mu.size(); ++i) {
        const Expression& f = of_source[source[i]];
        const double now = static_cast<double>(age[i]);
        double value = f(now, place(i));
        if (value < 0 && f((1 - 1e-5) * now, place(i)) >= 0) value = 0;  // ages are rounded
        if (!is_viscosity(value) && !report.diverged)
            report.diverged = Divergence{"ageing", "viscosity", step.time, x[i].cast<double>(),
                                         fmt::format("it is {:.4g} Pa s at the age of {:.4g} s", value, now)};
        mu[i] = static_cast<Real>(value);
        if (role[i] >= 0) age[i] += step.dt;
    }
}

}  // namespace

void AgeingViscosity::operator()(const StepContext& step, StepReport& report, Read<field::role> role, Read<field::position> x,
                                 Read<field::source> source, Update<field::age> age, Write<field::viscosity> mu) const {
    const auto nowhere = [](Index) { return Vec3d(Vec3d::Zero()); };
    grow_older(of_source, step, report, role, x, source, nowhere, age, mu);
}

void AgeingViscosityByPlace::operator()(const StepContext& step, StepReport& report, Read<field::role> role, Read<field::position> x,
                                        Read<field::source> source, Read<field::birthplace> start, Update<field::age> age,
                                        Write<field::viscosity> mu) const {
    const auto at_start = [&](Index i) { return Vec3d(start[i].cast<double>()); };
    grow_older(of_source, step, report, role, x, source, at_start, age, mu);
}

void GrowOlder::operator()(const StepContext& step, Read<field::role> role, Update<field::age> age) const {
    parallel_for(age.size(), [&](Index i) {
        if (role[i] >= 0) age[i] += step.dt;
    });
}

}  // namespace whorl
