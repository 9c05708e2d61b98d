/// Pressure models against fluids at rest and in free fall.
#include <catch2/catch.hpp>
#include <cmath>

#include "engine/core/random.h"
#include "engine/models/boundary/wall.h"
#include "engine/models/motion/motion.h"
#include "engine/models/pressure/constraint.h"
#include "engine/models/pressure/damping.h"
#include "engine/models/pressure/poisson.h"
#include "engine/models/pressure/wcsph.h"
#include "engine/models/viscosity/explicit_viscosity.h"
#include "engine/sph/density.h"
#include "tests/support/world.h"

using namespace whorl;
using namespace whorl::test;

namespace pressure_test {

namespace {

constexpr double d = 0.01, g = 9.81, rho_0 = 1000;

enum class Model { wcsph, poisson, constraint };
const char* name_of(Model model) { return model == Model::wcsph ? "wcsph" : model == Model::poisson ? "poisson" : "constraint"; }

struct Setting {
    Model model = Model::wcsph;
    double sound_speed = 0;
    Real smoothing = 0;  ///< XSPH, settles the particles of ppe
    bool damped = true;  ///< wcsph: with the two dampers as scenes have them
};

std::vector<Stage> stages_of(const Setting& s) {
    const Real factor = continued_lattice_factor(KernelKind::cubic, Real(2 * d), Real(d));
    WeaklyCompressible tait;
    tait.sound_speed = s.sound_speed;
    tait.solid_factor = factor;
    tait.sound_damping = s.damped ? 1 : 0;
    tait.artificial_viscosity = s.damped ? 0.1 : 0;
    std::vector<Stage> all{make_stage("density", "density", Density{factor})};
    if (s.model == Model::wcsph) all.push_back(make_stage("tait", "pressure", TaitPressure{tait}));
    if (s.model == Model::wcsph && s.damped) all.push_back(make_stage("sound damping", "pressure", SoundDamping{tait}));
    all.push_back(make_stage("gravity", "move", Gravity{}));
    if (s.model == Model::wcsph) all.push_back(make_stage("pressure", "pressure", PressureAcceleration{tait}));
    if (s.model == Model::wcsph && s.damped) all.push_back(make_stage("artificial viscosity", "pressure", ArtificialViscosity{tait}));
    all.push_back(make_stage("kick", "move", Kick{}));
    if (s.smoothing > 0) all.push_back(make_stage("xsph", "viscosity", XsphViscosity{s.smoothing}));
    if (s.model == Model::constraint) {
        all.push_back(make_stage("damping", "pressure", DampUnresolved(2)));
        all.push_back(make_stage("pressure", "pressure", ConstraintPressure(ConstraintOptions{})));
    }
    if (s.model == Model::poisson) {
        PoissonPressureOptions options;
        options.solid_factor = factor;
        all.push_back(make_stage("pressure", "pressure", PoissonPressure(options)));
    }
    all.push_back(make_stage("move", "move", Move{}));
    return all;
}

/// p/(rho g depth) over the lowest three layers, the depth from the mass above: 1 in hydrostatic equilibrium.
double bottom_pressure(TestWorld& w, int layers) {
    const auto x = w.column<field::position>();
    const auto p = w.column<field::pressure>();
    double sum = 0, exact = 0;
    for (std::size_t i = 0; i < x.size(); ++i)
        if (x[i].y() < 3 * d) {
            sum += p[i];
            exact += rho_0 * g * (layers * d - x[i].y());
        }
    return sum / exact;
}

/// @param jitter of the particles at the start, in spacings
void carries_its_weight(Model model, double jitter) {
    const int layers = 30;
    const double H = layers * d;
    // The lattice is no stable packing: left perfect it melts when round-off has grown enough, with wcsph 0.7 s after the start in float
    // and later in double, in a jolt. Scenes start their lattices moved by up to 0.01 d for that reason (engine/sim/place.cpp), and so does
    // this column.
    INFO(name_of(model) << ", jitter " << jitter << " d");
    const bool wcsph = model == Model::wcsph;
    Setting s;
    s.model = model;
    s.sound_speed = 10 * std::sqrt(2 * g * H);
    s.smoothing = wcsph ? Real(0) : Real(0.1);
    TestWorld w(d, 2, Domain{Vec3::Zero(), Vec3(Real(6 * d), Real(2 * H), Real(6 * d)), {true, false, true}});
    w.use(stages_of(s));
    w.world.step.gravity = Vec3(0, Real(-g), 0);
    w.add_wall(1, +1, 0);
    w.place(Vec3::Zero(), Vec3(Real(6 * d), Real(H), Real(6 * d)));
    RandomNumbers random(1);
    for (Vec3& x : w.column<field::position>())
        for (int a = 0; a < 3; ++a) x[a] += static_cast<Real>(jitter * d * (2 * random() - 1));
    const double dt = wcsph ? sound_step(0.4, 2 * d, s.sound_speed, 0.1) : 1e-3;
    // Settle, then the mean over 0.2 s: single steps of ppe scatter by 2 to 4 %.
    const int settle = static_cast<int>((wcsph ? 1.0 : 0.6) / dt), average = static_cast<int>(0.2 / dt);
    for (int k = 0; k < settle; ++k) w.step(dt);
    double mean = 0;
    for (int k = 0; k < average; ++k) {
        w.step(dt);
        mean += bottom_pressure(w, layers) / average;
    }
    CHECK(mean == Approx(1).epsilon(0.02));
    CHECK(w.max_speed() < (wcsph ? 0.01 : 0.02) * std::sqrt(2 * g * H));
}

}  // namespace

TEST_CASE("the pressure below a column of 30 layers is its weight within 2 %, in all pressure models", "[validation][pressure][long]") {
    carries_its_weight(Model::poisson, 0);
    carries_its_weight(Model::constraint, 0);
    carries_its_weight(Model::wcsph, 0.05);
}

TEST_CASE("the same of a weakly compressible column whose lattice is hardly disturbed at the start", "[validation][pressure][long]") {
    carries_its_weight(Model::wcsph, 0.01);
}

TEST_CASE("two blocks that collide in free space keep momentum within 1e-5 and angular momentum within 1e-4", "[validation][pressure]") {
    // Forces along pairs, and each the opposite of the other: what is left is round-off and how far the solver got, which both cancel in
    // the sums. In units of one block's momentum and of that times the distance between their paths.
    Setting s;
    s.model = Model::constraint;
    TestWorld w(d, 2, Domain{Vec3(-1, -1, -1), Vec3(1, 1, 1), {}});
    w.use(stages_of(s));
    w.world.step.gravity = Vec3::Zero();
    w.place(Vec3(Real(-7 * d), 0, 0), Vec3(Real(-d), Real(6 * d), Real(6 * d)), 0, [](const Vec3&) { return Vec3(1, 0, 0); });
    w.place(Vec3(Real(d), Real(3 * d), 0), Vec3(Real(7 * d), Real(9 * d), Real(6 * d)), 0, [](const Vec3&) { return Vec3(-1, 0, 0); });
    const double one = rho_0 * std::pow(6 * d, 3), spin = one * 3 * d;
    const Vec3d before = w.momentum(), turning = w.angular_momentum();
    for (int k = 0; k < 100; ++k) w.step(1e-3);
    CHECK((w.momentum() - before).norm() < 1e-5 * one);
    CHECK((w.angular_momentum() - turning).norm() < 1e-4 * spin);
    double energy = 0;
    for (const Vec3& u : w.column<field::velocity>()) energy += static_cast<double>(u.squaredNorm()) / 2 * rho_0 * d * d * d;
    CHECK(energy < one);  // the two halves of it at the start
}

}  // namespace pressure_test
