#include "engine/models/micropolar/micropolar.h"

#include <catch2/catch.hpp>
#include <cstring>

#include "engine/core/parallel.h"
#include "engine/core/random.h"
#include "engine/models/boundary/wall.h"
#include "engine/scene/read.h"
#include "engine/sim/simulation.h"
#include "engine/sph/density.h"
#include "tests/support/runs.h"
#include "tests/support/world.h"

using namespace whorl;
using namespace whorl::test;

namespace {

const std::string eddies = R"toml([time]
end = 0.02
[domain]
min = [0, 0, 0]
max = [0.5, 0.5, 0.5]
periodic = [true, true, true]
[fluid]
spacing = 0.05
viscosity = 4
[models]
pressure = "wcsph"
viscosity = "explicit"
micropolar = "seed"
[micropolar]
transfer_viscosity = 2
micro_inertia = 0.01
torque = ["0", "0.1*sin(t)", "x"]
[[block]]
shape = "box"
min = [0, 0, 0]
max = [0.5, 0.5, 0.5]
velocity = ["sin(4*pi*y)", "0", "0"]
)toml";

/// A cloud of uneven particles with a free surface.
struct Cloud : TestWorld {
    RandomNumbers random{3};
    Cloud() : TestWorld(0.1, 2, Domain{Vec3::Constant(-2), Vec3::Constant(2), {}}) {
        use({make_stage("density", "density", Density{})});
        place(Vec3::Zero(), Vec3::Constant(Real(0.6)));
        for (Vec3& x : column<field::position>()) x += Real(0.03) * vector();
        find_pairs();
        stages[0].run(world);
    }
    Vec3 vector() { return {Real(random()) - Real(0.5), Real(random()) - Real(0.5), Real(random()) - Real(0.5)}; }
    std::vector<Vec3> curl_of(CurlForm form, const std::vector<Vec3>& u) {
        std::vector<Vec3> all(u.size());
        with_kernel(world.step.kernel, world.step.support, [&](const auto& W) {
            for (std::size_t i = 0; i < u.size(); ++i)
                all[i] = curl(form, world.fluid_pairs, static_cast<Index>(i), W, world.step.mass,
                              std::as_const(world.fluid).column<field::density>(), Span<const Vec3>(u));
        });
        return all;
    }
};

}  // namespace

TEST_CASE("the symmetric curl and the difference with the own density are adjoint, at a free surface too, the other pairs are not",
          "[micropolar]") {
    Cloud cloud;
    const std::size_t n = static_cast<std::size_t>(cloud.world.fluid.size());
    std::vector<Vec3> u(n), w(n);
    for (std::size_t i = 0; i < n; ++i) u[i] = cloud.vector(), w[i] = cloud.vector();
    const auto rho = cloud.column<field::density>();
    const auto product = [&](const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
        double sum = 0;
        for (std::size_t i = 0; i < n; ++i) sum += static_cast<double>(a[i].dot(b[i]) / rho[i]);
        return sum;
    };
    const auto defect = [&](CurlForm of_u, CurlForm of_w) {
        const double flow = product(u, cloud.curl_of(of_w, w)), spin = product(w, cloud.curl_of(of_u, u));
        return std::abs(flow - spin) / std::max(std::abs(flow), std::abs(spin));
    };
    CHECK(defect(CurlForm::difference_own_density, CurlForm::symmetric) < 1e-4);
    CHECK(defect(CurlForm::symmetric, CurlForm::difference_own_density) < 1e-4);
    CHECK(defect(CurlForm::difference, CurlForm::symmetric) > 1e-3);
    CHECK(defect(CurlForm::symmetric, CurlForm::symmetric) > 1e-2);
}

TEST_CASE("the difference curls of a rigid rotation are twice its rate within the lattice's factor, and of a constant zero",
          "[micropolar]") {
    TestWorld w(0.1, 2, Domain{Vec3::Zero(), Vec3::Ones(), {true, true, true}});
    w.use({make_stage("density", "density", Density{})});
    w.place(Vec3::Zero(), Vec3::Ones());
    w.find_pairs();
    w.stages[0].run(w.world);
    const auto x = w.column<field::position>();
    std::vector<Vec3> turning(x.size()), constant(x.size(), Vec3(1, 2, 3));
    const Vec3 rate(Real(0.3), Real(-0.2), Real(0.5));
    Index middle = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        turning[i] = rate.cross(x[i]);
        if ((x[i] - Vec3::Constant(Real(0.45))).norm() < Real(0.02)) middle = static_cast<Index>(i);
    }
    const double factor = lattice_gradient(w.world.step.kernel, w.world.step.support, w.world.step.spacing);
    with_kernel(w.world.step.kernel, w.world.step.support, [&](const auto& W) {
        for (const CurlForm form : {CurlForm::difference, CurlForm::difference_own_density}) {
            const auto at_middle = [&](const std::vector<Vec3>& u) {
                return curl(form, w.world.fluid_pairs, middle, W, w.world.step.mass, std::as_const(w.world.fluid).column<field::density>(),
                            Span<const Vec3>(u));
            };
            // The density on this lattice is 1.0004 times that at rest.
            CHECK((at_middle(turning) - 2 * Real(factor) * rate).norm() < 2e-3);
            CHECK(at_middle(constant).norm() < 1e-4);
        }
    });
}

TEST_CASE("a scene without a micropolar model has neither spin nor anything else of it", "[micropolar]") {
    std::string plain = eddies;
    plain.erase(plain.find("micropolar = \"seed\""), plain.find("[[block]]") - plain.find("micropolar = \"seed\""));
    Simulation with = simulation_of(eddies), without = simulation_of(plain);
    CHECK(with.world().fluid.has<field::spin>());
    for (const char* name : {"spin", "spin_change"}) CHECK(without.world().fluid.find(name) == nullptr);
    for (const Stage& stage : without.assembly().stages) CHECK(stage.group != "micropolar");
    without.step(1);
    CHECK_FALSE(without.totals().any_work);
}

TEST_CASE("a micropolar run has the same bits with one thread and with two", "[micropolar]") {
    const auto state = [](int count) {
        const int before = threads();
        set_threads(count);
        Simulation simulation = simulation_of(eddies);
        for (int k = 0; k < 5; ++k) simulation.step(1);
        set_threads(before);
        const auto w = simulation.world().fluid.column<field::spin>();
        const auto u = simulation.world().fluid.column<field::velocity>();
        std::vector<Vec3> all(w.begin(), w.end());
        all.insert(all.end(), u.begin(), u.end());
        return std::pair(all, simulation.totals().work.total());
    };
    const auto [one, one_work] = state(1);
    const auto [two, two_work] = state(2);
    REQUIRE(one.size() == two.size());
    CHECK(std::memcmp(one.data(), two.data(), one.size() * sizeof(Vec3)) == 0);
    CHECK(one_work == two_work);
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

TEST_CASE("the gate at solids is shut far from them, open in contact, and rises without a jump between", "[micropolar][boundary]") {
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
        return with_kernel(w.world.step.kernel, w.world.step.support,
                           [&](const auto& W) { return gate.weight(W, 0, w.world.solid_pairs, w.world.solid_particles.volume, factor); });
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
    CHECK(SolidGate{}.weight(CubicKernel(1), 0, w.world.solid_pairs, w.world.solid_particles.volume, factor) == 1);
}
