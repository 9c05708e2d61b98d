#include "engine/models/micropolar/micropolar.h"

#include <catch2/catch.hpp>

#include "engine/core/random.h"
#include "engine/models/boundary/wall.h"
#include "engine/models/viscosity/explicit_viscosity.h"
#include "engine/scene/names.h"
#include "engine/scene/read.h"
#include "engine/simulation/simulation.h"
#include "engine/sph/density.h"
#include "tests/support/micropolar_flows.h"
#include "tests/support/runs.h"
#include "tests/support/scene_text.h"
#include "tests/support/world.h"

using namespace whorl;
using namespace whorl::test;

namespace {

const std::string eddies = text::time(0.02) + text::domain({0, 0, 0}, {0.5, 0.5, 0.5}, "periodic = [true, true, true]") +
                           text::fluid(0.05, 4) + text::models("wcsph", "explicit") + "micropolar = \"notes\"\n" +
                           "[micropolar]\ntransfer_viscosity = 2\nmicro_inertia = 0.01\ntorque = [\"0\", \"0.1*sin(t)\", \"x\"]\n" +
                           text::block({0, 0, 0}, {0.5, 0.5, 0.5}, "velocity = [\"sin(4*pi*y)\", \"0\", \"0\"]");

/// A cloud of uneven particles with a free surface, with noise for velocities and spins.
struct Cloud : TestWorld {
    RandomNumbers random{3};
    Cloud() : TestWorld(0.1, 2, Domain{Vec3::Constant(-2), Vec3::Constant(2), {}}) {
        use({make_stage("density", "density", Density{}), make_stage("micropolar", "micropolar", Micropolar({}))});
        place(Vec3::Zero(), Vec3::Constant(Real(0.6)));
        for (Vec3& x : column<field::position>()) x += Real(0.03) * vector();
        for (Vec3& u : column<field::velocity>()) u = vector();
        for (Vec3& w : column<field::spin>()) w = vector();
        find_pairs();
        stages[0].run(world);
    }
    Vec3 vector() { return {Real(random()) - Real(0.5), Real(random()) - Real(0.5), Real(random()) - Real(0.5)}; }
    /// Factor by which a step multiplies its curls and its first Laplacian (docs/physics.md 4).
    double factor() const { return 1 / lattice_gradient(world.step.kernel, world.step.support, world.step.spacing); }

    /// sum_j f(i, j, r_ij, grad W_ij, W_ij) of every particle over all others, in double.
    template <class F>
    std::vector<Vec3d> sums(const F& f) {
        const auto x = column<field::position>();
        const CubicKernel W(world.step.support);
        std::vector<Vec3d> all(x.size(), Vec3d::Zero());
        for (std::size_t i = 0; i < x.size(); ++i)
            for (std::size_t j = 0; j < x.size(); ++j) {
                const Vec3 r = x[i] - x[j];
                const Real distance = r.norm();
                if (i == j || !(distance < world.step.support)) continue;
                const Vec3d gradient = static_cast<double>(W.derivative(distance) / distance) * r.cast<double>();
                all[i] += f(i, j, r.cast<double>(), gradient, static_cast<double>(W.value(distance)));
            }
        return all;
    }
    /// The curl of v as the notes print it (with the cross product that their difference forms lack).
    std::vector<Vec3d> printed_curl(CurlForm form, Span<const Vec3> v) {
        const auto rho = column<field::density>();
        const double m = world.step.mass;
        return sums([&](std::size_t i, std::size_t j, const Vec3d&, const Vec3d& gradient, double) -> Vec3d {
            const double rho_i = rho[i], rho_j = rho[j];
            const Vec3d v_i = v[i].cast<double>(), v_j = v[j].cast<double>();
            switch (form) {
                case CurlForm::symmetric: return -rho_i * m * (v_i / (rho_i * rho_i) + v_j / (rho_j * rho_j)).cross(gradient);
                case CurlForm::difference: return m / rho_j * (v_i - v_j).cross(gradient);
                default: return m / rho_i * (v_i - v_j).cross(gradient);
            }
        });
    }
};

constexpr CurlForm all_curls[] = {CurlForm::symmetric, CurlForm::difference, CurlForm::difference_own_density};

/// Largest difference over the largest value.
double difference(const std::vector<Vec3>& found, const std::vector<Vec3d>& expected, double factor) {
    double most = 0, apart = 0;
    for (std::size_t i = 0; i < found.size(); ++i) {
        most = std::max(most, factor * expected[i].norm());
        apart = std::max(apart, (found[i].cast<double>() - factor * expected[i]).norm());
    }
    return apart / most;
}

}  // namespace

TEST_CASE("every curl of a step is the sum that the notes print, times the lattice's factor, to 1e-5", "[micropolar]") {
    Cloud cloud;
    const auto u = cloud.column<field::velocity>(), w = cloud.column<field::spin>();
    for (const CurlForm form : all_curls) {
        INFO(name_of(form));
        const Curls curls = curls_of(cloud, form, form);
        CHECK(difference(curls.velocity, cloud.printed_curl(form, u), cloud.factor()) < 1e-5);
        CHECK(difference(curls.spin, cloud.printed_curl(form, w), cloud.factor()) < 1e-5);
    }
}

TEST_CASE("both Laplacians are the notes' sums with symmetric weights times a lattice factor, to 1e-5", "[micropolar]") {
    Cloud cloud;
    const auto rho = cloud.column<field::density>();
    const auto u = cloud.column<field::velocity>(), w = cloud.column<field::spin>();
    const StepContext& step = cloud.world.step;
    const double m = step.mass, softening = 0.01 * std::pow(static_cast<double>(step.support) / 2, 2);
    // Instead of m/(rho_i rho_j). Any weight that is symmetric in i and j conserves momentum: here (1/rho_i^2 + 1/rho_j^2)/2.
    const auto weight = [&](std::size_t i, std::size_t j) { return m * (std::pow(rho[i], -2.0) + std::pow(rho[j], -2.0)) / 2; };
    const auto first = [&](Span<const Vec3> v) {
        return cloud.sums([&](std::size_t i, std::size_t j, const Vec3d& r, const Vec3d& gradient, double) -> Vec3d {
            return weight(i, j) * 2 * gradient.norm() / r.norm() * (v[j] - v[i]).template cast<double>();
        });
    };
    const std::vector<Vec3d> second = cloud.sums([&](std::size_t i, std::size_t j, const Vec3d& r, const Vec3d& gradient, double) -> Vec3d {
        return weight(i, j) * 10 * (u[i] - u[j]).template cast<double>().dot(r) / (r.squaredNorm() + softening) * gradient;
    });
    cloud.world.step.dt = 1;
    MicropolarOptions options;
    options.pair_viscosity = options.spin_viscosity = options.micro_inertia = 1;
    options.implicit_exchange = false;
    const MicropolarStep made = micropolar_step(cloud, options);
    CHECK(difference(made.acceleration, first(u), cloud.factor()) < 1e-5);
    CHECK(difference(made.spin_change, first(w), cloud.factor()) < 1e-5);
    options.pair_viscosity = 0, options.central_viscosity = 1;
    CHECK(difference(micropolar_step(cloud, options).acceleration, second, along_pairs_factor(step.kernel, step.support, step.spacing)) <
          1e-5);
}

TEST_CASE("without coupling the micropolar force equals explicit viscosity to 1e-5, also at a wall", "[micropolar][viscosity][boundary]") {
    for (const bool central : {false, true}) {
        INFO((central ? "monaghan" : "brookshaw"));
        TestWorld w(0.1, 2.5, Domain{Vec3::Zero(), Vec3(Real(0.6), Real(0.8), Real(0.6)), {true, false, true}});
        const Real factor = continued_lattice_factor(w.world.step.kernel, w.world.step.support, w.world.step.spacing);
        w.use({make_stage("density", "density", Density{factor}), make_stage("micropolar", "micropolar", Micropolar({}))});
        w.add_wall(1, +1, 0);
        w.place(Vec3::Zero(), Vec3(Real(0.6), Real(0.6), Real(0.6)), 1);
        RandomNumbers random(5);
        for (Vec3& x : w.column<field::position>())
            for (int a = 0; a < 3; ++a) x[a] += Real(0.02) * (Real(random()) - Real(0.5));
        for (Vec3& u : w.column<field::velocity>()) u = Vec3(Real(random()), Real(random()), Real(random()));
        // Equal densities, because the two stages weight unequal densities differently.
        for (Real& rho : w.column<field::density>()) rho = 1000;
        w.find_pairs();
        w.world.step.dt = 1;
        MicropolarOptions options;
        (central ? options.central_viscosity : options.pair_viscosity) = 1;
        options.solid_factor = factor;
        const std::vector<Vec3> with_spin = micropolar_step(w, options).acceleration;
        std::vector<Vec3> without(with_spin.size(), Vec3::Zero());
        const ParticleStore& fluid = w.world.fluid;
        ExplicitViscosity{{.laplacian = central ? LaplacianForm::monaghan : LaplacianForm::brookshaw, .solid_factor = factor}}(
            w.world.context(), {fluid.column<field::role>()}, {fluid.column<field::density>()}, {fluid.column<field::viscosity>()},
            {fluid.column<field::velocity>()}, {{Span<Vec3>(without)}});
        double most = 0, apart = 0;
        for (std::size_t i = 0; i < without.size(); ++i) {
            most = std::max<double>(most, without[i].norm());
            apart = std::max<double>(apart, (with_spin[i] - without[i]).norm());
        }
        CHECK(apart < 1e-5 * most);
    }
}

TEST_CASE("XSPH in a micropolar step equals its sums with alpha and beta, or per given time, to 1e-5", "[micropolar]") {
    Cloud cloud;
    const auto rho = cloud.column<field::density>();
    const auto smoothed = [&](Span<const Vec3> v) {
        return cloud.sums([&](std::size_t i, std::size_t j, const Vec3d&, const Vec3d&, double W) -> Vec3d {
            return 2 * static_cast<double>(cloud.world.step.mass) / static_cast<double>(rho[i] + rho[j]) * W *
                   (v[j] - v[i]).template cast<double>();
        });
    };
    const double dt = 0.01, alpha = 0.002, beta = 0.125;
    cloud.world.step.dt = static_cast<Real>(dt);
    MicropolarOptions options;
    options.smoothing_velocity = alpha, options.smoothing_spin = beta;
    for (const double time : {0.0, 0.05}) {  // 0: in every step
        INFO("xsph_time " << time);
        options.smoothing_time = time;
        const double share = time > 0 ? dt / time : 1;
        const MicropolarStep made = micropolar_step(cloud, options);
        CHECK(difference(made.acceleration, smoothed(cloud.column<field::velocity>()), share * alpha / dt) < 1e-5);
        CHECK(difference(made.spin_change, smoothed(cloud.column<field::spin>()), share * beta) < 1e-5);
    }
}

TEST_CASE("the symmetric curl and the difference curl with rho_i are adjoint, also at a surface", "[micropolar]") {
    Cloud cloud;
    const auto u = cloud.column<field::velocity>(), w = cloud.column<field::spin>();
    const auto rho = cloud.column<field::density>();
    const auto defect = [&](CurlForm of_u, CurlForm of_w) {
        const Curls curls = curls_of(cloud, of_u, of_w);
        double flow = 0, spin = 0;
        for (std::size_t i = 0; i < rho.size(); ++i)
            flow += static_cast<double>(u[i].dot(curls.spin[i]) / rho[i]),
                spin += static_cast<double>(w[i].dot(curls.velocity[i]) / rho[i]);
        return std::abs(flow - spin) / std::max(std::abs(flow), std::abs(spin));
    };
    CHECK(defect(CurlForm::difference_own_density, CurlForm::symmetric) < 1e-4);
    CHECK(defect(CurlForm::symmetric, CurlForm::difference_own_density) < 1e-4);
    CHECK(defect(CurlForm::difference, CurlForm::symmetric) > 1e-3);
    CHECK(defect(CurlForm::symmetric, CurlForm::symmetric) > 1e-2);
}

TEST_CASE("the composed coupling dissipates kappa/2 |curl u - 2 w|^2, at surfaces and walls", "[micropolar]") {
    // Its forces are the derivatives of that energy: any arrangement of particles loses it, to the round-off of single precision.
    for (const bool wall : {false, true})
        for (const bool co_rotating : {true, false}) {
            CAPTURE(wall, co_rotating);
            Cloud cloud;
            if (wall) cloud.add_wall(1, +1, 0), cloud.find_pairs(), cloud.stages[0].run(cloud.world);
            cloud.world.step.dt = 1;
            MicropolarOptions options;
            options.coupling = options.micro_inertia = 1;
            options.implicit_exchange = false, options.co_rotating = co_rotating;
            const std::vector<Vec3> relative = micropolar_step(cloud, options).spin_change;  // (curl u - 2 w)/rho
            options.composed_coupling = 1;
            const MicropolarStep made = micropolar_step(cloud, options);
            const auto u = cloud.column<field::velocity>(), w = cloud.column<field::spin>(), x = cloud.column<field::position>();
            const auto rho = cloud.column<field::density>();
            double power = 0, expected = 0, size = 0;
            Vec3d push = Vec3d::Zero(), turn = Vec3d::Zero();
            for (std::size_t i = 0; i < rho.size(); ++i) {
                power += static_cast<double>(u[i].dot(made.acceleration[i]) + w[i].dot(made.spin_change[i]));
                expected -= static_cast<double>(rho[i] * relative[i].squaredNorm()) / 2;
                size += static_cast<double>(made.acceleration[i].norm());
                push += made.acceleration[i].cast<double>();
                turn += (x[i].cross(made.acceleration[i]) + made.spin_change[i]).cast<double>();
            }
            CHECK(power == Approx(expected).epsilon(1e-4));
            if (wall) continue;
            CHECK(push.norm() < 1e-5 * size);
            if (co_rotating) CHECK(turn.norm() < 1e-5 * size);
        }
}

TEST_CASE("on a lattice every curl of a rigid rotation is twice its rate, and of a constant zero", "[micropolar]") {
    TestWorld w(0.1, 2, Domain{Vec3::Zero(), Vec3::Ones(), {true, true, true}});
    w.use({make_stage("density", "density", Density{}), make_stage("micropolar", "micropolar", Micropolar({}))});
    w.place(Vec3::Zero(), Vec3::Ones());
    w.find_pairs();
    w.stages[0].run(w.world);
    const auto x = w.column<field::position>();
    const Vec3 rate(Real(0.3), Real(-0.2), Real(0.5));
    Index middle = 0;
    for (std::size_t i = 0; i < x.size(); ++i)
        if ((x[i] - Vec3::Constant(Real(0.45))).norm() < Real(0.02)) middle = static_cast<Index>(i);
    const auto set = [&](auto&& value) {
        for (std::size_t i = 0; i < x.size(); ++i) w.column<field::velocity>()[i] = w.column<field::spin>()[i] = value(x[i]);
    };
    for (const CurlForm form : all_curls) {
        INFO(name_of(form));
        set([&](const Vec3& at) -> Vec3 { return rate.cross(at); });
        const Curls turning = curls_of(w, form, form);
        // The density on this lattice is 1.0004 times that at rest.
        CHECK((turning.velocity[middle] - 2 * rate).norm() < 2e-3);
        CHECK((turning.spin[middle] - 2 * rate).norm() < 2e-3);
        set([&](const Vec3&) -> Vec3 { return {1, 2, 3}; });
        const Curls constant = curls_of(w, form, form);
        CHECK(constant.velocity[middle].norm() < 1e-4);
        CHECK(constant.spin[middle].norm() < 1e-4);
    }
}

TEST_CASE("a scene without a micropolar model has no spin and no other micropolar field", "[micropolar]") {
    std::string plain = eddies;
    plain.erase(plain.find("micropolar = \"notes\""), plain.find("[[block]]") - plain.find("micropolar = \"notes\""));
    Simulation with = simulation_of(eddies), without = simulation_of(plain);
    CHECK(with.world().fluid.has<field::spin>());
    for (const char* name : {"spin", "spin_change"}) CHECK(without.world().fluid.find(name) == nullptr);
    for (const Stage& stage : without.assembly().stages) CHECK(stage.group != "micropolar");
    without.step(1);
    CHECK_FALSE(without.totals().any_work);
}

TEST_CASE("a uniform torque turns fluid at rest as theta dw/dt = tau - 2 kappa w", "[micropolar]") {
    MicropolarOptions options;
    options.coupling = 1000;
    options.micro_inertia = 0.1;
    options.torque = {{Expression(0.0), Expression(0.0), Expression(3.0)}};
    TestWorld w(0.1, 2, Domain{Vec3::Zero(), Vec3::Constant(Real(0.4)), {true, true, true}});
    w.use({make_stage("density", "density", Density{}), make_stage("micropolar", "micropolar", Micropolar(options))});
    w.place(Vec3::Zero(), Vec3::Constant(Real(0.4)));
    for (int k = 0; k < 400; ++k) w.step(1e-3);
    // 1 - exp(-8) of tau/(2 kappa); the density on this lattice is 1.0004.
    CHECK(w.column<field::spin>()[5].z() == Approx(1.5).epsilon(0.002));
}

TEST_CASE("the gate at solids is 0 far away, 1 in contact, and rises continuously between", "[micropolar][boundary]") {
    const double d = 0.1;
    TestWorld w(d, 2, Domain{Vec3(0, Real(-0.5), 0), Vec3(Real(0.8), 2, Real(0.8)), {true, false, true}});
    w.use({make_stage("density", "density", Density{})});
    w.add_wall(1, +1, 0);
    w.world.fluid.resize(1);
    const Real factor = continued_lattice_factor(w.world.step.kernel, w.world.step.support, w.world.step.spacing);
    const SolidGate gate{Real(0.06)};
    const auto weight = [&](double height) {
        w.column<field::position>()[0] = Vec3(Real(0.4), Real(height), Real(0.4));
        w.find_pairs();
        return with_kernel(w.world.step.kernel, w.world.step.support, [&](const auto& W) {
            return gate.weight(W, 0, w.world.solid_pairs, w.world.boundary_particles.volume, factor);
        });
    };
    CHECK(weight(d / 2) == 1);
    CHECK(weight(1.2 * d) == 0);
    double before = weight(0), steepest = 0;
    for (double height = 0; height < 1.5 * d; height += 0.01 * d) {
        const double now = weight(height);
        CHECK(now <= before + 1e-6);
        steepest = std::max(steepest, before - now);
        before = now;
    }
    CHECK(steepest < 0.1);
    CHECK(SolidGate{}.weight(CubicKernel(1), 0, w.world.solid_pairs, w.world.boundary_particles.volume, factor) == 1);
}
