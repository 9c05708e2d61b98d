#include "engine/models/viscosity/ageing_viscosity.h"

#include "engine/core/parallel.h"

namespace whorl {
namespace {

// One after the other: expressions are not thread-safe.
template <class Place>
void grow_older(const std::vector<Expression>& of_source, Real dt, Read<field::role> role, Read<field::source> source, const Place& place,
                Update<field::age> age, Write<field::viscosity> mu) {
    for (Index i = 0; i < mu.size(); ++i) {
        const Expression& f = of_source[source[i]];
        mu[i] = static_cast<Real>(std::max(0.0, f(static_cast<double>(age[i]), place(i))));
        if (role[i] >= 0) age[i] += dt;
    }
}

}  // namespace

void AgeingViscosity::operator()(const StepContext& step, Read<field::role> role, Read<field::source> source, Update<field::age> age,
                                 Write<field::viscosity> mu) const {
    grow_older(
        of_source, step.dt, role, source, [](Index) { return Vec3d(Vec3d::Zero()); }, age, mu);
}

void AgeingViscosityByPlace::operator()(const StepContext& step, Read<field::role> role, Read<field::source> source,
                                        Read<field::birthplace> start, Update<field::age> age, Write<field::viscosity> mu) const {
    grow_older(
        of_source, step.dt, role, source, [&](Index i) { return Vec3d(start[i].cast<double>()); }, age, mu);
}

void GrowOlder::operator()(const StepContext& step, Read<field::role> role, Update<field::age> age) const {
    parallel_for(age.size(), [&](Index i) {
        if (role[i] >= 0) age[i] += step.dt;
    });
}

}  // namespace whorl
