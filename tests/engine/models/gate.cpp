/// The gate at solids, in every model with solid forces.
#include "engine/sph/gate.h"

#include <catch2/catch.hpp>
#include <string_view>

#include "engine/core/random.h"
#include "engine/models/boundary/wall.h"
#include "engine/models/micropolar/micropolar.h"
#include "engine/models/motion/fickian.h"
#include "engine/models/motion/motion.h"
#include "engine/models/pressure/wcsph.h"
#include "engine/models/viscosity/assembled_viscosity.h"
#include "engine/models/viscosity/explicit_viscosity.h"
#include "engine/models/viscosity/full_viscosity.h"
#include "engine/sph/density.h"
#include "tests/support/world.h"

using namespace whorl;
using namespace whorl::test;

namespace gate_test {

namespace {

constexpr double d = 0.1, side = 6 * d;
/// Gate threshold: a lattice layer 1.2 spacings above a wall has less than half of it, a layer in contact more than 1.5 times it.
constexpr Real threshold = Real(0.06);

Real solid_factor() { return continued_lattice_factor(KernelKind::cubic, Real(2 * d), Real(d)); }

struct Model {
    const char* name;
    bool knows_slip_length;
    std::function<std::vector<Stage>(SolidGate)> stages;
};

template <class Options>
Options options_with(SolidGate gate) {
    Options options;
    options.solid_factor = solid_factor();
    options.gate = gate;
    return options;
}

/// Forces, then the kick.
std::vector<Stage> kicked(SolidGate gate, std::vector<Stage> forces) {
    std::vector<Stage> all{make_stage("density", "density", Density{solid_factor(), gate}), make_stage("gravity", "move", Gravity{})};
    for (Stage& force : forces) all.push_back(std::move(force));
    all.push_back(make_stage("kick", "move", Kick{}));
    return all;
}

template <class S>
Stage stage(S s) {
    return make_stage("tested", "tested", std::move(s));
}

std::vector<Stage> sound(SolidGate gate) {
    auto options = options_with<PressureOptions>(gate);
    options.sound_speed = 10;
    options.background_pressure = 1e4;
    options.sound_damping = 1, options.artificial_viscosity = 1;
    return kicked(gate, {stage(TaitPressure{options}), stage(SoundDamping{options}), stage(PressureAcceleration{options}),
                         stage(ArtificialViscosity{options})});
}

std::vector<Stage> explicit_laplacian(SolidGate gate, bool monaghan) {
    auto options = options_with<ViscosityOptions>(gate);
    if (monaghan) options.laplacian = LaplacianForm::monaghan;
    return kicked(gate, {stage(ExplicitViscosity{options})});
}

std::vector<Stage> spin(SolidGate gate) {
    auto options = options_with<MicropolarOptions>(gate);
    options.coupling = options.pair_viscosity = options.central_viscosity = options.spin_viscosity = options.micro_inertia = 1;
    return kicked(gate, {stage(Micropolar(options))});
}

std::vector<Stage> implicit(SolidGate gate, bool correction) {
    auto options = options_with<ViscosityOptions>(gate);
    options.limits.tolerance = 1e-6;
    options.correction = correction;
    std::vector<Stage> all = kicked(gate, {});
    all.push_back(correction ? stage(FullViscosity(options)) : stage(UncorrectedViscosity(options)));
    return all;
}

std::vector<Stage> assembled(SolidGate gate) {
    auto options = options_with<ViscosityOptions>(gate);
    options.limits.tolerance = 1e-6;
    std::vector<Stage> all = kicked(gate, {});
    all.push_back(stage(AssembledViscosity(options)));
    return all;
}

std::vector<Stage> shifting(SolidGate gate) {
    return {make_stage("density", "density", Density{solid_factor(), gate}), stage(FickianShift{solid_factor(), gate})};
}

const std::vector<Model>& models() {
    static const std::vector<Model> all{{"wcsph", false, sound},
                                        {"brookshaw", true, [](SolidGate gate) { return explicit_laplacian(gate, false); }},
                                        {"monaghan", true, [](SolidGate gate) { return explicit_laplacian(gate, true); }},
                                        {"full", true, [](SolidGate gate) { return implicit(gate, true); }},
                                        {"full without correction", false, [](SolidGate gate) { return implicit(gate, false); }},
                                        {"full_assembled", false, assembled},
                                        {"micropolar", false, spin},
                                        {"fickian", false, shifting}};
    return all;
}

enum class Wall { none, sticks, slips };

/// A lattice of fluid with noisy velocities above the plane y = 0, after a step.
/// @param height of the lowest layer [spacings]
TestWorld stepped(const Model& model, Real gate, Wall wall, double height) {
    TestWorld w(d, 2, Domain{Vec3(0, -1, 0), Vec3(Real(side), 2, Real(side)), {true, false, true}});
    w.use(model.stages(SolidGate{gate}));
    if (wall != Wall::none) w.add_wall(1, +1, 0, wall == Wall::slips ? d : 0);
    const double low = (height - 0.5) * d;
    w.place(Vec3(0, Real(low), 0), Vec3(Real(side), Real(low + side), Real(side)), 10);
    RandomNumbers random(2);
    for (Vec3& u : w.column<field::velocity>()) u = Vec3(Real(random()), Real(random()), Real(random()));
    w.step(1e-3);
    return w;
}

/// Largest difference of velocities and positions, over 1 m/s and one spacing.
double apart(TestWorld a, TestWorld b) {
    double most = 0;
    for (Index i = 0; i < a.world.fluid.size(); ++i) {
        most = std::max<double>(most, (a.column<field::velocity>()[i] - b.column<field::velocity>()[i]).norm());
        most = std::max<double>(most, (a.column<field::position>()[i] - b.column<field::position>()[i]).norm() / d);
    }
    return most;
}

}  // namespace

TEST_CASE("in every model a gated wall acts fully on fluid in contact and not at all farther away", "[boundary]") {
    for (const Model& model : models())
        for (const Wall wall : {Wall::sticks, Wall::slips}) {
            if (wall == Wall::slips && !model.knows_slip_length) continue;
            INFO(model.name << (wall == Wall::slips ? ", slip length" : ""));
            constexpr double far = 1.2, near = 0.5, round_off = 2e-6;
            CHECK(apart(stepped(model, threshold, wall, far), stepped(model, 0, Wall::none, far)) < round_off);
            CHECK(apart(stepped(model, threshold, wall, near), stepped(model, 0, wall, near)) < round_off);
            // Without the gate this wall acts. (Shifting stops if the fluid is as sparse as above a gap.)
            if (std::string_view(model.name) != "fickian")
                CHECK(apart(stepped(model, 0, wall, far), stepped(model, 0, Wall::none, far)) > 5 * round_off);
        }
}

}  // namespace gate_test
