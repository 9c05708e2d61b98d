#include "tools/measure/solver/viscous_models.h"

#include "engine/geometry/shape.h"
#include "engine/models/motion/motion.h"
#include "engine/models/viscosity/assembled_viscosity.h"
#include "engine/models/viscosity/explicit_viscosity.h"
#include "engine/models/viscosity/full_viscosity.h"
#include "engine/particles/sample.h"
#include "engine/sph/density.h"

namespace whorl {
namespace {

template <class F>
Read<F> read(test::TestWorld& w) {
    return {std::as_const(w.world.fluid).template column<F>()};
}

/// -(A u - u)/dt of an implicit operator that is set up with a short step.
template <class Operator, class SetUp>
std::vector<Vec3> acceleration_of(test::TestWorld& w, const SetUp& set_up) {
    const auto u = w.column<field::velocity>();
    w.world.step.dt = Real(1);
    Operator A;
    set_up(A, w.world);
    std::vector<Vec3> y(u.size());
    A.force(u, y);
    for (std::size_t i = 0; i < y.size(); ++i) y[i] = u[i] - y[i];
    return y;
}

std::vector<Vec3> explicit_acceleration(test::TestWorld& w, bool monaghan) {
    std::vector<Vec3> a(w.column<field::velocity>().size(), Vec3::Zero());
    World& c = w.world;
    ExplicitViscosity{{monaghan, 1}}(c.surroundings(), read<field::role>(w), read<field::density>(w), read<field::viscosity>(w),
                                     read<field::velocity>(w), {{Span<Vec3>(a)}});
    return a;
}

/// XSPH with alpha such that alpha 0.075 R^2/(2 dt) is nu.
std::vector<Vec3> xsph_acceleration(test::TestWorld& w) {
    const StepContext& step = w.world.step;
    const Real nu = w.column<field::viscosity>()[0] / step.rest_density;
    std::vector<Vec3> change(w.column<field::velocity>().size()), u(w.column<field::velocity>().begin(), w.column<field::velocity>().end());
    XsphViscosity{1}(w.world.surroundings(), read<field::role>(w), read<field::density>(w), {Span<Vec3>(change)}, {{Span<Vec3>(u)}});
    for (Vec3& a : change) a *= nu / (Real(0.0375) * step.support * step.support);
    return change;
}

std::vector<Stage> around(Stage viscosity, bool acceleration) {
    std::vector<Stage> all{make_stage("density", "density", Density{}), make_stage("gravity", "move", Gravity{})};
    if (acceleration) all.push_back(std::move(viscosity));
    all.push_back(make_stage("kick", "move", Kick{}));
    if (!acceleration) all.push_back(std::move(viscosity));
    return all;
}

}  // namespace

std::vector<ViscousModel> viscous_models() {
    const auto stage = [](auto s) { return make_stage("viscosity", "viscosity", std::move(s)); };
    std::vector<ViscousModel> all;
    all.push_back({"xsph", false, 2, xsph_acceleration, {}});
    for (const bool monaghan : {false, true})
        all.push_back({monaghan ? "explicit monaghan" : "explicit brookshaw", false, monaghan ? 4.0 : 2.0,
                       [monaghan](test::TestWorld& w) { return explicit_acceleration(w, monaghan); },
                       [=](double) {
                           return around(stage(ExplicitViscosity{{monaghan, 1}}), true);
                       }});
    all.push_back({"full_assembled", true, 2,
                   [](test::TestWorld& w) {
                       return acceleration_of<AssembledOperator>(w, [&](AssembledOperator& A, World& c) {
                           A.set_up({.penalty = 0}, c.surroundings(), read<field::role>(w), read<field::density>(w),
                                    read<field::viscosity>(w));
                       });
                   },
                   [=](double tolerance) {
                       AssembledViscosityOptions o;
                       o.limits = {tolerance, 5000}, o.penalty = 0;
                       return around(stage(AssembledViscosity(o)), false);
                   }});
    all.push_back({"full", true, 2,
                   [](test::TestWorld& w) {
                       return acceleration_of<ViscousOperator>(w, [&](ViscousOperator& A, World& c) {
                           A.set_up({}, c.surroundings(), read<field::role>(w), read<field::viscosity>(w));
                       });
                   },
                   [=](double tolerance) {
                       FullViscosityOptions o;
                       o.limits = {tolerance, 5000};
                       return around(stage(FullViscosity(o)), false);
                   }});
    return all;
}

test::TestWorld body(const std::vector<Vec3>& x, double spacing, double support, double mu, const std::vector<Stage>& stages) {
    Vec3 low = Vec3::Constant(std::numeric_limits<Real>::max()), high = -low;
    for (const Vec3& one : x) low = low.cwiseMin(one), high = high.cwiseMax(one);
    const Vec3 room = Vec3::Constant(static_cast<Real>(4 * support * spacing));
    test::TestWorld w(spacing, support, Domain{low - room, high + room, {}});
    w.use(stages);
    w.world.fluid.declare(field_info<field::density>(), true);
    w.world.fluid.resize(static_cast<Index>(x.size()));
    std::copy(x.begin(), x.end(), w.column<field::position>().begin());
    for (Real& one : w.column<field::viscosity>()) one = static_cast<Real>(mu);
    w.world.step.gravity.setZero();
    w.find_pairs();
    Density{}(w.world.surroundings(), {w.column<field::density>()});
    return w;
}

std::vector<Vec3> rope(double radius, double length, double spacing) {
    ShapeKeys keys;
    keys.kind = "cylinder";
    keys.from = Vec3d(-length / 2, 0, 0);
    keys.to = Vec3d(length / 2, 0, 0);
    keys.radius = radius;
    Domain domain;
    domain.max = Vec3::Constant(static_cast<Real>(length));
    domain.min = -domain.max;
    return sample_shape(*make_shape(keys), Sampling::blue_noise, static_cast<Real>(spacing), domain, 1);
}

}  // namespace whorl
