/// Heat on given particles, against exact solutions (docs/physics.md 15).
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "engine/core/random.h"
#include "engine/geometry/plane.h"
#include "engine/models/temperature/heat.h"
#include "tests/support/world.h"

using namespace whorl;
using namespace whorl::test;

namespace temperature_test {

namespace {

constexpr double d = 0.01, pi = std::numbers::pi, rho = 1000;
constexpr double k = 1, c = 1000, alpha = k / (rho * c);  // d^2/alpha = 100 s

HeatOptions material() { return {.conductivity = k, .capacity = c}; }

SolidHeat at_temperature(double T) { return {.temperature = Expression(T), .film = {}, .flux = {}}; }

/// Fluid with heat alone.
struct Warm {
    TestWorld w;
    HeatOptions options;

    /// @param support in spacings; the coupled solve has 2.4
    Warm(const Domain& domain, const HeatOptions& material, double support = 2.4)
        : w(d, support, domain, KernelKind::wendland_c2), options(material) {}
    void add(std::shared_ptr<const Shape> shape, SolidHeat heat = {}, bool inside = false) {
        Solid solid;
        solid.shape = std::move(shape), solid.inside = inside;
        w.world.solids.all.push_back(solid), heats_.push_back(std::move(heat));
    }
    void begin(const Vec3& min, const Vec3& max, double T, double loose = 0) {
        w.use({make_stage("heat", "heat", Heat(options, heats_))});
        w.place(min, max);
        RandomNumbers random(5);
        for (Vec3& x : w.column<field::position>())
            for (int a = 0; a < w.world.step.dimensions(); ++a) x[a] += static_cast<Real>(loose * d * (2 * random() - 1));
        set(T);
    }
    void set(double T) {
        for (Real& one : w.column<field::temperature>()) one = static_cast<Real>(T);
    }
    void run(double time, int steps) {
        for (int s = 0; s < steps; ++s) w.step(time / steps);
    }
    double temperature(std::size_t i) {
        return static_cast<double>(w.column<field::temperature>()[i]) + static_cast<double>(w.column<field::temperature_rest>()[i]);
    }
    double heat() {  ///< J
        double sum = 0;
        for (std::size_t i = 0; i < w.column<field::position>().size(); ++i) sum += options.law().enthalpy(temperature(i));
        return sum * static_cast<double>(w.world.step.mass);
    }
    /// Difference from the exact temperature f(y): the largest on a lattice. Off it the root mean square, because the temperature of a
    /// single particle there differs by up to what it changes over the displacement.
    template <class F>
    double error(const F& f, double loose = 0) {
        double worst = 0, square = 0;
        const auto x = w.column<field::position>();
        for (std::size_t i = 0; i < x.size(); ++i) {
            const double off = std::abs(temperature(i) - f(static_cast<double>(x[i].y())));
            worst = std::max(worst, off), square += off * off / static_cast<double>(x.size());
        }
        return loose > 0 ? std::sqrt(square) : worst;
    }

private:
    std::vector<SolidHeat> heats_;
};

/// A strip along y, periodic along x, 8 d wide and n d high.
Domain strip(int n) { return {Vec3(0, -1, 0), Vec3(static_cast<Real>(8 * d), static_cast<Real>(n * d + 1), 0), {true, false, false}}; }
Vec3 corner(int n) { return {static_cast<Real>(8 * d), static_cast<Real>(n * d), 0}; }
auto floor_at(double y) { return make_plane(Vec3d(0, y, 0), Vec3d(0, 1, 0)); }
auto ceiling_at(double y) { return make_plane(Vec3d(0, y, 0), Vec3d(0, -1, 0)); }

}  // namespace

TEST_CASE("conduction between plates follows the series and becomes linear within 1 %", "[temperature]") {
    const int n = 20;
    const double L = n * d;
    for (const double loose : {0.0, 0.2}) {
        Warm fluid(strip(n), material());
        fluid.add(floor_at(0), at_temperature(300)), fluid.add(ceiling_at(L), at_temperature(320));
        fluid.begin(Vec3::Zero(), corner(n), 300, loose);
        const double time = 0.1 * L * L / alpha;
        fluid.run(time, 100);
        const auto series = [&](double y) {
            double T = 300 + 20 * y / L;
            for (int m = 1; m < 20; ++m)
                T += 40 / (m * pi) * (m % 2 == 0 ? 1 : -1) * std::sin(m * pi * y / L) * std::exp(-m * m * pi * pi * 0.1);
            return T;
        };
        CAPTURE(loose, fluid.error(series, loose));
        CHECK(fluid.error(series, loose) < 0.2);
        for (int s = 0; s < 20; ++s) fluid.run(time, 1);  // each 40 d^2/alpha
        const auto linear = [&](double y) { return 300 + 20 * y / L; };
        CAPTURE(fluid.error(linear, loose));
        CHECK(fluid.error(linear, loose) < 0.2);
    }
}

TEST_CASE("a half-space that touches a hot plate follows erf within 1 %, also off the lattice and in motion", "[temperature]") {
    const int n = 60;
    for (const double loose : {0.0, 0.2}) {
        Warm fluid(strip(n), material());
        fluid.add(floor_at(0), at_temperature(400));
        fluid.begin(Vec3::Zero(), corner(n), 300, loose);
        const double time = 64 * d * d / alpha;  // sqrt(alpha t) = 8 d
        for (int s = 0; s < 100; ++s) {
            for (Vec3& x : fluid.w.column<field::position>()) x.x() += loose > 0 ? static_cast<Real>(0.37 * d) : 0;
            fluid.run(time / 100, 1);
        }
        const auto exact = [&](double y) { return 400 - 100 * std::erf(y / (2 * std::sqrt(alpha * time))); };
        CAPTURE(loose, fluid.error(exact, loose));
        CHECK(fluid.error(exact, loose) < 1);
    }
}

TEST_CASE("moving fluid keeps its heat to 1e-6 of the heat that it exchanges, also while it melts", "[temperature]") {
    HeatOptions options = material();
    options.latent_heat = 5e4, options.melting_range = {310, 330};
    const Real side = static_cast<Real>(30 * d);
    Warm fluid(Domain{Vec3::Zero(), Vec3(side, side, 0), {true, true, false}}, options);
    fluid.begin(Vec3::Zero(), Vec3(side, side, 0), 300, 0.3);
    const auto x = fluid.w.column<field::position>();
    for (std::size_t i = 0; i < x.size(); ++i) fluid.w.column<field::temperature>()[i] = x[i].x() < side / 2 ? Real(300) : Real(360);
    const double before = fluid.heat(), contrast = rho * 900 * d * d * c * 30;
    RandomNumbers random(7);
    for (int s = 0; s < 50; ++s) {
        for (Vec3& one : fluid.w.column<field::position>())
            for (int a = 0; a < 2; ++a) one[a] += static_cast<Real>(0.2 * d * (2 * random() - 1));
        fluid.run(s % 5 == 0 ? 2000 : 10, 1);
    }
    CAPTURE((fluid.heat() - before) / contrast);
    CHECK(std::abs(fluid.heat() - before) < 1e-6 * contrast);
    for (std::size_t i = 0; i < x.size(); ++i) {
        REQUIRE(fluid.temperature(i) > 299.9);
        REQUIRE(fluid.temperature(i) < 360.1);
    }
}

TEST_CASE("a ball that cools through a film follows the series of the sphere within 3 %", "[temperature]") {
    const int across = 18;
    const Real side = static_cast<Real>(across * d);
    HeatOptions options = material();
    const double radius = 8 * d;
    options.air = 300, options.film = k / radius;  // Biot number 1
    Warm ball(Domain{Vec3::Constant(-1), Vec3::Constant(2), {}}, options);
    ball.begin(Vec3::Zero(), Vec3::Zero(), 0);
    std::vector<Vec3> inside;
    for (int a = 0; a < across; ++a)
        for (int b = 0; b < across; ++b)
            for (int e = 0; e < across; ++e) {
                const Vec3 x(Real(a + 0.5) * Real(d), Real(b + 0.5) * Real(d), Real(e + 0.5) * Real(d));
                if ((x - Vec3::Constant(side / 2)).norm() < static_cast<Real>(radius)) inside.push_back(x);
            }
    ball.w.put(inside);
    ball.set(400);
    const double R = std::cbrt(static_cast<double>(inside.size()) * d * d * d * 3 / (4 * pi)), time = 0.3 * R * R / alpha;
    ball.run(time, 60);
    double mean = 0;  // lambda = (2 n - 1) pi/2 solve 1 - lambda cot lambda = 1
    for (int n = 1; n < 8; ++n) {
        const double lambda = (2 * n - 1) * pi / 2;
        mean += 6 / std::pow(lambda, 4) * std::exp(-lambda * lambda * 0.3);
    }
    const double found = (ball.heat() / (static_cast<double>(inside.size()) * rho * d * d * d * c) - 300) / 100;
    CAPTURE(found, mean);
    CHECK(found == Approx(mean).margin(0.03));
}

TEST_CASE("a melting front follows Stefan's solution within 5 %", "[temperature]") {
    const int n = 40;
    HeatOptions options = material();
    options.latent_heat = 2e4, options.melting_range = {299.8, 300.2};  // Stefan number 1 with a wall of 320 K
    for (const double loose : {0.0, 0.2}) {
        Warm fluid(strip(n), options);
        fluid.add(floor_at(0), at_temperature(320));
        fluid.begin(Vec3::Zero(), corner(n), 299.8, loose);
        const double time = 150 * d * d / alpha;
        fluid.run(time, 600);
        double melted = 0;
        for (std::size_t i = 0; i < fluid.w.column<field::position>().size(); ++i)
            melted += std::clamp((fluid.temperature(i) - 299.8) / 0.4, 0.0, 1.0) * d / 8;
        const double lambda = 0.6201, front = 2 * lambda * std::sqrt(alpha * time);  // 15 d
        CAPTURE(loose, melted / front);
        CHECK(melted == Approx(front).epsilon(0.05));
    }
}

TEST_CASE("a plate of given flux gives the fluid its heat within 1 %, and 4 % off the lattice", "[temperature]") {
    for (const double loose : {0.0, 0.2}) {
        Warm fluid(strip(20), material());
        fluid.add(floor_at(0), {.temperature = {}, .film = {}, .flux = Expression(500.0)});
        fluid.begin(Vec3::Zero(), corner(20), 300, loose);
        const double before = fluid.heat();
        fluid.run(1000, 50);
        const double given = 500 * 8 * d * 1000;
        CAPTURE(loose, (fluid.heat() - before) / given);
        CHECK(fluid.heat() - before == Approx(given).epsilon(loose > 0 ? 0.04 : 0.01));
    }
}

TEST_CASE("a film between a plate and fluid slows the exchange as 1/h", "[temperature]") {
    // Steady between a plate at 320 K with a film and one at 300 K: the flux is 20/(L/k + 1/h).
    const double L = 20 * d, h = 5;
    Warm fluid(strip(20), material());
    fluid.add(floor_at(0), {.temperature = Expression(320.0), .film = h, .flux = {}}), fluid.add(ceiling_at(L), at_temperature(300));
    fluid.begin(Vec3::Zero(), corner(20), 300);
    for (int s = 0; s < 30; ++s) fluid.run(L * L / alpha, 1);
    const double flux = 20 / (L / k + 1 / h);
    CHECK(fluid.error([&](double y) { return 300 + flux * (L - y) / k; }) < 0.2);
}

namespace {

/// Area that the particles show [m^2 or m], by the power of a small step.
double shown_area(Warm& fluid, double film, double difference) {
    fluid.run(1e-3, 1);
    double lost = 0;
    for (std::size_t i = 0; i < fluid.w.column<field::position>().size(); ++i) lost += 400 - fluid.temperature(i);
    return lost * static_cast<double>(fluid.w.world.step.mass) * c / (1e-3 * film * difference);
}

}  // namespace

TEST_CASE("particles show the area of a box, a ball and a sheet within 7 %, and none to walls", "[temperature]") {
    HeatOptions options = material();
    options.air = 300, options.film = 1e-3;
    for (const double loose : {0.0, 0.2}) {
        Warm box(Domain{Vec3::Constant(-1), Vec3::Constant(1), {}}, options);
        box.begin(Vec3::Zero(), Vec3::Constant(static_cast<Real>(12 * d)), 400, loose);
        CHECK(shown_area(box, 1e-3, 100) == Approx(6 * 144 * d * d).epsilon(0.07));
        for (const int layers : {1, 2, 5}) {
            const Real side = static_cast<Real>(10 * d);
            Warm sheet(Domain{Vec3(0, -1, 0), Vec3(side, 1, side), {true, false, true}}, options);
            sheet.begin(Vec3::Zero(), Vec3(side, static_cast<Real>(layers * d), side), 400, layers > 2 ? loose : 0);
            CAPTURE(layers, loose);
            CHECK(shown_area(sheet, 1e-3, 100) == Approx(2 * 100 * d * d).epsilon(0.07));
        }
    }
    const Real side = static_cast<Real>(12 * d);  // in a tank: the top alone
    Warm tank(Domain{Vec3::Constant(-1), Vec3::Constant(1), {}}, options);
    tank.add(make_box(Vec3d::Zero(), Vec3d(12 * d, 20 * d, 12 * d)), {}, true);
    tank.begin(Vec3::Zero(), Vec3::Constant(side), 400);
    CHECK(shown_area(tank, 1e-3, 100) == Approx(144 * d * d).epsilon(0.1));
}

TEST_CASE("a well conducting drop radiates as a lumped body", "[temperature]") {
    HeatOptions options = material();
    options.conductivity = 1000, options.emissivity = 0.8, options.air = 1;
    Warm drop(Domain{Vec3::Constant(-1), Vec3::Constant(1), {}}, options);
    drop.begin(Vec3::Zero(), Vec3::Constant(static_cast<Real>(8 * d)), 1200);
    const double time = 500, before = 1200;
    drop.run(time, 100);
    const double A = 6 * 64 * d * d, m = rho * 512 * d * d * d;
    const double exact = std::pow(1 / (before * before * before) + 3 * 0.8 * 5.670374e-8 * A * time / (m * c), -1.0 / 3);
    CAPTURE(drop.temperature(0), exact);
    CHECK(before - drop.temperature(0) == Approx(before - exact).epsilon(0.06));  // the area of a box of 8 spacings
}

}  // namespace temperature_test
