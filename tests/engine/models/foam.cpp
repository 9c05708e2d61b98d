/// Air in fluid that breaks up.
#include "engine/models/foam/foam.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <sstream>

#include "engine/core/parallel.h"
#include "engine/scene/read.h"
#include "tests/support/runs.h"
#include "tests/support/scene_text.h"
#include "tests/support/world.h"

using namespace whorl;
using namespace whorl::test;

namespace foam_test {

namespace {

constexpr double d = 0.01;

TestWorld open_block(const std::function<Vec3(const Vec3&)>& velocity) {
    TestWorld w(d, 2, Domain{Vec3::Constant(-1), Vec3::Constant(1)});
    w.use({make_stage("foam", "foam", Foam{})});
    w.place(Vec3::Zero(), Vec3::Constant(static_cast<Real>(10 * d)), 0, velocity);
    return w;
}

Real most(Span<const Real> values) { return *std::max_element(values.begin(), values.end()); }

/// Share of the particles with more than this foam.
double share_above(Span<const Real> foam, Real limit) {
    return static_cast<double>(std::count_if(foam.begin(), foam.end(), [&](Real f) { return f > limit; })) /
           static_cast<double>(foam.size());
}

/// A column of water in a tank.
Simulation dam_break() {
    namespace t = text;
    Scene scene = read_scene_text(t::time(1) + t::domain({-0.1, -0.1, -0.1}, {0.8, 0.8, 0.3}) + t::fluid(0.02) + t::models("ppe", "xsph") +
                                      t::block({0, 0, 0}, {0.2, 0.4, 0.2}) + t::tank({0, 0, 0}, {0.7, 0.6, 0.2}),
                                  "test.toml");
    scene.foam = true;
    return Simulation(scene, make_plan(scene));
}

}  // namespace

TEST_CASE("a block at rest stays clear", "[foam]") {
    TestWorld w = open_block({});
    for (int k = 0; k < 100; ++k) w.step(0.005);
    CHECK(most(w.column<field::foam>()) == 0);
    CHECK(most(w.column<field::airborne>()) == 0);
}

TEST_CASE("a block that falls fast stays clear except for its leading edges", "[foam]") {
    TestWorld w = open_block([](const Vec3&) { return Vec3(0, -3, 0); });
    for (int k = 0; k < 100; ++k) w.step(0.005);
    const auto x = w.column<field::position>();
    const auto foam = w.column<field::foam>();
    for (std::size_t i = 0; i < x.size(); ++i) {
        const bool edge = x[i].y() < 2 * d && std::max(std::abs(x[i].x() - 0.05f), std::abs(x[i].z() - 0.05f)) > 0.03f;
        INFO("at " << x[i].transpose());
        if (!edge) REQUIRE(foam[i] < 0.1f);  // mixed in from the edges
    }
}

TEST_CASE("fast particles without neighbours turn to spray, and clear within seconds once they are slow", "[foam]") {
    TestWorld w(d, 2, Domain{Vec3::Constant(-1), Vec3::Constant(1)});
    w.use({make_stage("foam", "foam", Foam{})});
    for (int k = 0; k < 5; ++k)
        w.place(Vec3(static_cast<Real>(3 * k * d), 0, 0),
                Vec3(static_cast<Real>((3 * k + 1) * d), static_cast<Real>(d), static_cast<Real>(d)), 0,
                [](const Vec3&) { return Vec3(0, 1, 0); });
    for (int k = 0; k < 20; ++k) w.step(0.005);
    for (const Real f : w.column<field::foam>()) CHECK(std::clamp(f, Real(0.9), Real(1)) == f);
    for (const Real t : w.column<field::airborne>()) CHECK(t == Approx(0.1));
    for (Vec3& u : w.column<field::velocity>()) u.setZero();
    for (int k = 0; k < 800; ++k) w.step(0.005);
    CHECK(most(w.column<field::foam>()) < 0.01f);
    CHECK(most(w.column<field::airborne>()) < 1e-6f);
}

TEST_CASE("a small drop is spray if it is white, and clear fluid if it is not", "[foam]") {
    const auto all_spray = [](Real foam) {
        TestWorld w(d, 2, Domain{Vec3::Constant(-1), Vec3::Constant(1)});
        w.use({make_stage("foam", "foam", Foam{})});
        w.place(Vec3::Zero(), Vec3(static_cast<Real>(2 * d), static_cast<Real>(2 * d), static_cast<Real>(3 * d)), 0,
                [](const Vec3&) { return Vec3(0, 1, 0); });
        for (Real& f : w.column<field::foam>()) f = foam;
        w.step(0.001);
        const auto airborne = w.column<field::airborne>();
        return std::all_of(airborne.begin(), airborne.end(), [](Real t) { return t > 0; });
    };
    CHECK(all_spray(1));
    CHECK_FALSE(all_spray(0));
}

TEST_CASE("foam of a dam break starts at the wall, stays between 0 and 1, and moves no particle", "[foam]") {
    Simulation with = dam_break();
    Scene plain = with.scene();
    plain.foam = false;
    Simulation without(plain, make_plan(plain));
    const auto foam = [&] { return with.world().fluid.column<field::foam>(); };
    for (const double end : {0.15, 0.2}) run_until(without, end);
    run_until(with, 0.15);
    CHECK(share_above(foam(), 0.2f) < 0.02);
    for (double end = 0.2; end < 0.75; end += 0.1) {
        run_until(with, end);
        if (end == 0.2) {
            const auto x = positions(with), y = positions(without);
            REQUIRE(x.size() == y.size());
            CHECK(std::equal(x.begin(), x.end(), y.begin()));
        }
        for (const Real f : foam()) REQUIRE(std::clamp(f, Real(0), Real(1)) == f);
    }
    CHECK(share_above(foam(), 0.5f) > 0.05);
}

TEST_CASE("foam has the same bits on 1 and 4 threads and after a resume", "[foam]") {
    const int before = threads();
    set_threads(1);
    Simulation whole = dam_break();
    run_until(whole, 0.2);
    const std::string half_way = state_of(whole);
    run_until(whole, 0.4);
    set_threads(4);
    Simulation resumed = dam_break();
    std::istringstream saved(half_way);
    resumed.load(saved);
    run_until(resumed, 0.4);
    set_threads(before);
    CHECK(state_of(resumed) == state_of(whole));
}

}  // namespace foam_test
