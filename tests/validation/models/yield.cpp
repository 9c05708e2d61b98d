/// Fluids that do not flow until their yield stress is exceeded, against exact flows (docs/physics.md 4, "Yield stress").
#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "engine/models/viscosity/flow_law.h"
#include "tests/support/runs.h"
#include "tests/support/scene_text.h"

using namespace whorl;
using namespace whorl::test;

namespace {

/// The models "coupled", or "ppe" with the projection and the viscosity in its full form.
std::string models_of(const std::string& pressure) {
    return pressure == "coupled" ? text::models(pressure) : text::models(pressure, "full") + "[pressure]\nform = \"projection\"\n";
}

/// Flow along x that the acceleration `drive` keeps up: a film of depth h on the plane y = 0, or half a channel of width 2 h. With tau =
/// rho drive (h - y) the fluid shears below y0 = h - tau_y/(rho drive) and is a plug above:
///   u = n/(n + 1) (rho drive/K)^(1/n) (y0^(1 + 1/n) - max(y0 - y, 0)^(1 + 1/n))
struct Sheared {
    double tau_y = 50, K = 5, n = 1, drive = 1, h = 0.1;
    bool channel = false;
    double rho = 1000, steepness = 9.8;  ///< steepness: gravity towards the plane
    int dimensions = 2;

    double edge() const { return std::max(0.0, h - tau_y / (rho * drive)); }
    double exact(double y) const {
        const double wall = channel ? std::min(y, 2 * h - y) : y, m = 1 + 1 / n;
        return std::pow(rho * drive / K, 1 / n) / m * (std::pow(edge(), m) - std::pow(std::max(0.0, edge() - wall), m));
    }
    /// @param across spacings in h @param start the exact velocity times this at the start
    std::string scene(const std::string& pressure, int across, double end, double step, double start = 1) const {
        const double d = h / across, width = (dimensions == 2 ? 10 : 8) * d, depth = channel ? 2 * h : h, m = 1 + 1 / n;
        const std::string wall = channel ? fmt::format("min(y, {:.17g} - y)", 2 * h) : "y", deep = dimensions == 3 ? ", 0" : "",
                          law = n == 1 ? fmt::format("yield_stress = {}\nviscosity = {}\n", tau_y, K)
                                       : fmt::format("yield_stress = {}\nconsistency = {}\nflow_index = {}\n", tau_y, K, n),
                          velocity = fmt::format("velocity = [\"{:.17g}*({:.17g} - max({:.17g} - {}, 0)^{})\", 0{}]",
                                                 start * std::pow(rho * drive / K, 1 / n) / m, std::pow(edge(), m), edge(), wall, m, deep);
        const auto at = [&](double x, double y, double z) { return text::point(dimensions, x, y, z); };
        std::string text = text::time(end, fmt::format("max_step = {}", step)) +
                           text::domain(at(0, 0, 0), at(width, channel ? depth : 1.5 * h, width),
                                        fmt::format("periodic = [true, false{}]\ngravity = [{}, {}{}]", dimensions == 3 ? ", true" : "",
                                                    channel ? 0 : drive, channel ? 0 : -steepness, deep)) +
                           text::fluid(d, 0, law + (channel ? fmt::format("force = [{}, 0{}]\n", drive, deep) : "")) + models_of(pressure) +
                           text::block(at(0, 0, 0), at(width, depth, width), velocity) + text::plane(at(0, 0, 0), at(0, 1, 0));
        if (channel) text += text::plane({0, depth}, {0, -1});
        return text;
    }
};

struct Found {
    double worst = 0;  ///< error of the velocity, over the exact flow's largest
    double plug = 0;   ///< error of the position of each edge of the plug, where u is 2 % below the largest speed [spacings]
};

Found compare(const Sheared& flow, const Simulation& s) {
    Found found;
    const double fastest = flow.exact(flow.h);
    double top = 0, plug = 0, exact_plug = 0;
    for (const Vec3& u : velocities(s)) top = std::max(top, static_cast<double>(u.x()));
    const auto x = positions(s), u = velocities(s);
    for (std::size_t i = 0; i < x.size(); ++i) {
        const double exact = flow.exact(static_cast<double>(x[i].y())), now = static_cast<double>(u[i].x());
        found.worst = std::max(found.worst, std::abs(now - exact) / fastest);
        plug += now > 0.98 * top, exact_plug += exact > 0.98 * fastest;
    }
    found.plug = (plug - exact_plug) / (flow.channel ? 20 : 10);
    return found;
}

/// Flow between coaxial cylinders of radii a and b in 2D. The inner one turns, the outer one is at rest. The fluid shears up to the radius
/// e at which tau = tau_y e^2/r^2 is the yield stress, and is at rest beyond:
///   omega(r) = tau_y/K [(e^2/r^2 - 1)/2 - ln(e/r)]
struct Coaxial {
    double tau_y = 50, K = 5, a = 0.025, e = 0.042, b = 0.055, d = 1.5e-3;

    double exact(double r) const {
        const double in = std::min(r, e);
        return r * tau_y / K * ((e * e / (in * in) - 1) / 2 - std::log(e / in));
    }
    std::string scene(const std::string& pressure, double end) const {
        const std::string r2 = fmt::format("min(x^2 + y^2, {:.17g})", e * e),
                          omega = fmt::format("{:.17g}*(({:.17g}/{} - 1)/2 - ln({:.17g}/{})/2)", tau_y / K, e * e, r2, e * e, r2);
        return text::time(end, "max_step = 5e-3") + text::domain({-0.06, -0.06}, {0.06, 0.06}, "gravity = [0, 0]") +
               text::fluid(d, K, fmt::format("yield_stress = {}\n", tau_y)) + models_of(pressure) +
               text::drop({0, 0}, b, fmt::format("velocity = [\"-y*{}\", \"x*{}\"]", omega, omega)) +
               text::ball({0, 0}, b, "container = true") + text::ball({0, 0}, a, fmt::format("rotation = [0, 0, {:.17g}]", exact(a) / a));
    }
};

/// Compares the profile like compare() of a film. The plug is the fluid slower than 2 % of the inner cylinder.
Found compare(const Coaxial& flow, const Simulation& s) {
    Found found;
    const double fastest = flow.exact(flow.a);
    const auto x = positions(s), u = velocities(s);
    double moving = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        const Vec3d at = x[i].cast<double>(), now = u[i].cast<double>();
        const double r = at.norm(), exact = flow.exact(r);
        found.worst = std::max(found.worst, (now - exact / r * Vec3d(-at.y(), at.x(), 0)).norm() / fastest);
        moving += (now.norm() > 0.02 * fastest) - (exact > 0.02 * fastest);
    }
    found.plug = moving * flow.d / (2 * std::numbers::pi * flow.e);
    return found;
}

/// A layer 0.1 m deep on a slope of 0.2 rad, which starts with the exact velocity.
struct Slope {
    double over_yield = 1.1;
    int across = 40, dimensions = 2;
    std::string pressure = "coupled";

    Sheared flow() const {
        Sheared layer;
        layer.drive = 9.81 * std::sin(0.2), layer.steepness = 9.81 * std::cos(0.2), layer.dimensions = dimensions;
        layer.tau_y = layer.rho * layer.drive * layer.h / over_yield;
        return layer;
    }
    /// Mean velocity of the layer over the time from `from` to `end` [m/s].
    double speed(double from, double end) const {
        Simulation s = simulation_of(flow().scene(pressure, across, end, 5e-3));
        double way = 0, before = 0;
        run_until(s, end, [&] {
            const double now = s.time();
            if (now > from) way += (now - std::max(from, before)) * mean_of(s, [](const Vec3d&, const Vec3d& u) { return u.x(); });
            before = now;
        });
        return way / (before - from);
    }
    double exact() const {
        const Sheared layer = flow();
        return layer.exact(layer.h) * (1 - layer.edge() / layer.h / 3);
    }
};

}  // namespace

TEST_CASE("a Bingham film and channel flow keep the exact profile within 3 %, and their plug within a spacing", "[validation][yield]") {
    for (const char* pressure : {"ppe", "coupled"})
        for (const bool channel : {false, true}) {
            Sheared flow;
            flow.channel = channel;
            Simulation s = simulation_of(flow.scene(pressure, 20, 0.3, 5e-3));
            run_until(s, 0.3);
            const Found found = compare(flow, s);
            CAPTURE(pressure, channel, found.worst, found.plug);
            CHECK(found.worst < 0.03);
            CHECK(std::abs(found.plug) <= 1);
        }
}

TEST_CASE("a Herschel-Bulkley film with n = 0.5 keeps the exact profile within 4 %", "[validation][yield]") {
    for (const char* pressure : {"ppe", "coupled"}) {
        Sheared film;
        film.n = 0.5, film.K = 20, film.tau_y = 40;
        Simulation s = simulation_of(film.scene(pressure, 30, 0.3, 5e-3));
        run_until(s, 0.3);
        const Found found = compare(film, s);
        CAPTURE(pressure, found.worst, found.plug);
        CHECK(found.worst < 0.04);
    }
}

TEST_CASE("between coaxial cylinders a Bingham fluid keeps the exact profile within 3 %, and its plug within a spacing",
          "[validation][yield]") {
    for (const char* pressure : {"ppe", "coupled"}) {
        const Coaxial flow;
        Simulation s = simulation_of(flow.scene(pressure, 0.15));
        run_until(s, 0.15);
        const Found found = compare(flow, s);
        CAPTURE(pressure, found.worst, found.plug);
        CHECK(found.worst < 0.03);
        CHECK(std::abs(found.plug) <= 1);
    }
}

TEST_CASE("a layer on a slope creeps at .9 of its yield stress slower than 0.3 mm/s, and flows at 1.1", "[validation][yield]") {
    CHECK(Slope{.9}.speed(0.5, 0.6) < 3e-4);  // g_0 h 2.3 is 0.23 mm/s
    CHECK(Slope{}.speed(0.1, 0.6) == Approx(Slope{}.exact()).epsilon(0.03));
    CHECK(Slope{.9, 20, 2, "ppe"}.speed(0.2, 0.3) < 6e-4);
}

// The fluid shears within h (1 - 1/over_yield) of the plane. A zone of less than two spacings is not resolved: at 1.05 with d = 5 mm,
// "coupled" flows at 1.60 of the speed. With "ppe" the start disturbs the layer, which forgets it within .5 s at 1.1.
TEST_CASE("a layer on a slope at 1.05 to 2 times its yield stress flows at the exact speed", "[validation][yield][long]") {
    struct Case {
        Slope slope;
        double from, end, tolerance;
    };
    const auto [slope, from, end, tolerance] = GENERATE(values<Case>({
        {{1.05, 40, 2, "coupled"}, .2, 1, .2},  // a zone of 1.9 spacings
        {{1.1, 20, 2, "coupled"}, .2, 1, .1},   // 1.8 spacings
        {{1.1, 40, 2, "coupled"}, .2, 1, .05},
        {{1.3, 20, 2, "coupled"}, .2, 1, .05},
        {{1.3, 40, 2, "coupled"}, .2, 1, .05},
        {{2, 20, 2, "coupled"}, .2, 1, .05},
        {{2, 40, 2, "coupled"}, .2, 1, .05},
        {{1.1, 20, 3, "coupled"}, .2, 1, .1},
        {{1.3, 20, 3, "coupled"}, .2, 1, .05},
        {{2, 20, 3, "coupled"}, .2, 1, .05},
        {{1.1, 20, 2, "ppe"}, .6, 1, .15},
        {{1.1, 40, 2, "ppe"}, .6, 1, .1},
        {{1.3, 20, 2, "ppe"}, .2, 1, .05},
        {{1.3, 40, 2, "ppe"}, .2, .6, .05},
        {{2, 20, 2, "ppe"}, .2, 1, .05},
        {{2, 40, 2, "ppe"}, .2, .6, .05},
        {{1.3, 20, 3, "ppe"}, .2, .6, .05},
        {{2, 20, 3, "ppe"}, .2, .6, .05},
    }));
    CAPTURE(slope.pressure, slope.over_yield, slope.across, slope.dimensions);
    CHECK(slope.speed(from, end) == Approx(slope.exact()).epsilon(tolerance));
}

TEST_CASE("thin mud that collapses and splashes loses energy all the time", "[validation][yield]") {
    // At the shear rate of speed over spacing its viscous number is 0.01. With a bulk viscosity of 10 mu its energy rises to the threefold.
    Simulation s = simulation_of(text::time(1) + text::domain({0, 0}, {0.6, 0.3}) +
                                 text::fluid(8e-3, 0.4, "density = 1300\nyield_stress = 8") + text::models("coupled") +
                                 text::block({0, 0}, {0.12, 0.18}) + text::tank({0, 0}, {0.6, 0.3}) + text::box({0.28, 0}, {0.31, 0.03}));
    const auto energy = [&] { return mean_of(s, [](const Vec3d& x, const Vec3d& u) { return u.squaredNorm() / 2 + 9.81 * x.y(); }); };
    double before = energy();
    for (double t = 0.1; t < 0.65; t += 0.1) {
        run_until(s, t);
        CAPTURE(t);
        CHECK(energy() < before);
        before = energy();
    }
}

TEST_CASE("a heap of cream keeps 99 % of its height for .5 s, and one with a tenth of its yield stress sinks", "[validation][yield]") {
    const auto height = [](double yield_stress) {  // 38 mm of 1000 kg/m^3: rho g h/2 is 190 Pa
        Simulation s = simulation_of(text::time(0.5) + text::domain({-0.1, 0}, {0.1, 0.1}) +
                                     text::fluid(5e-3, 5, fmt::format("yield_stress = {}", yield_stress)) + text::models("coupled") +
                                     text::block({-0.02, 0}, {0.02, 0.04}) + text::plane({0, 0}, {0, 1}));
        run_until(s, 0.5);
        double top = 0;
        for (const Vec3& x : positions(s)) top = std::max(top, static_cast<double>(x.y()));
        return top + 2.5e-3;
    };
    CHECK(height(260) > 0.99 * 0.04);
    CHECK(height(26) < 0.7 * 0.04);
}

TEST_CASE("a heap of cream in 3D keeps 99 % of its height for 3 s", "[validation][yield][long]") {
    const double d = 4e-3, h = 0.04;  // 1000 kg/m^3: rho g h/2 is 196 Pa
    Simulation s =
        simulation_of(text::time(3) + text::domain({-0.1, 0, -0.1}, {0.1, 0.1, 0.1}) + text::fluid(d, 5, "yield_stress = 230") +
                      text::models("coupled") + text::block({-0.02, 0, -0.02}, {0.02, h, 0.02}) + text::plane({0, 0, 0}, {0, 1, 0}));
    run_until(s, 3);
    double top = 0;
    for (const Vec3& x : positions(s)) top = std::max(top, static_cast<double>(x.y()));
    CHECK(top + d / 2 > 0.99 * h);
}

TEST_CASE("a cylinder of mud spreads to the radius and height of Roussel and Coussot (2005) within 10 %", "[validation][yield][long]") {
    // A quarter of it, on a plane that it sticks to. Wide spread: tau_y = 225 rho g V^2/(128 pi^2 R^5), h = sqrt(2 tau_y (R - r)/(rho g)).
    const double d = 6e-3, tau_y = 30, weight = 9810;
    Simulation s = simulation_of(text::time(2) + text::domain({-0.06, 0, -0.06}, {0.15, 0.1, 0.15}) +
                                 text::fluid(d, 3, fmt::format("yield_stress = {}", tau_y)) + text::models("coupled") +
                                 "[[block]]\nshape = \"cylinder\"\nfrom = [0, 0, 0]\nto = [0, 0.05, 0]\nradius = 0.05\n" +
                                 text::plane({0, 0, 0}, {0, 1, 0}) + text::plane({0, 0, 0}, {1, 0, 0}, "slip = \"free\"") +
                                 text::plane({0, 0, 0}, {0, 0, 1}, "slip = \"free\""));
    const auto n = static_cast<double>(positions(s).size());
    const double V = 4 * n * d * d * d;
    run_until(s, 2);
    double radius = 0, centre = 0;
    for (const Vec3& x : positions(s)) {
        radius = std::max(radius, std::hypot(static_cast<double>(x.x()), static_cast<double>(x.z())) + d / 2);
        centre += static_cast<double>(x.y()) / n;
    }
    const double R = std::pow(225 * weight * V * V / (128 * std::pow(std::numbers::pi, 2) * tau_y), 0.2);
    CHECK(radius == Approx(R).epsilon(0.1));
    // The profile has its centre at 5/16 of its height. The highest particle is no measure of a height of four spacings: whether one
    // particle lies on top of the others changes it by half a spacing, 12 %.
    CHECK(16.0 / 5 * centre == Approx(std::sqrt(2 * tau_y * R / weight)).epsilon(0.1));
}

/// Slump of a round heap of volume V in which the fluid yields throughout its depth: tau = tau_y (1 - y/h) and a stress along the flow of
/// sigma_r - sigma_z = sqrt(3 (tau_y^2 - tau^2)), sqrt(3) pi/4 tau_y h over the depth, so that rho g h^2/2 - sqrt(3) pi/4 tau_y h = tau_y
/// (R - r). Without that stress it is the law of Roussel and Coussot.
struct RoundSlump {
    double radius = 0, centre = 0;  ///< m; centre: height of the centre of gravity

    RoundSlump(double tau_y, double weight, double V) {
        const double l = tau_y / weight, c = std::sqrt(3) * std::numbers::pi / 4, step = 1e-4;
        for (double volume = 0; volume < V; radius += step) {
            volume = centre = 0;
            for (double r = step / 2; r < radius; r += step) {
                const double h = l * (c + std::sqrt(c * c + 2 * (radius - r) / l)), ring = 2 * std::numbers::pi * r * step;
                volume += ring * h, centre += ring * h * h / 2 / V;
            }
        }
    }
};

TEST_CASE("a cylinder of ketchup spreads to the radius and height of a slump with stress along the flow within 10 %",
          "[validation][yield][long]") {
    // A quarter of it. Wide spread, with 2 R/l = 76: without stress along the flow the law has a radius that is 13 % too large. At 3 s the
    // ketchup still creeps at 0.7 mm/s, because its stress is 20 Pa s^0.3 gamma^0.3 above the yield stress. Measured: radius 2 %, centre 8
    // %.
    const double d = 6e-3, tau_y = 30, weight = 9810;
    Simulation s = simulation_of(
        text::time(3) + text::domain({-0.09, 0, -0.09}, {0.2, 0.05, 0.2}) +
        text::fluid(d, 0, fmt::format("yield_stress = {}\nconsistency = 20\nflow_index = 0.3", tau_y)) + text::models("coupled") +
        "[[block]]\nshape = \"cylinder\"\nfrom = [0, 0, 0]\nto = [0, 0.03, 0]\nradius = 0.08\n" + text::plane({0, 0, 0}, {0, 1, 0}) +
        text::plane({0, 0, 0}, {1, 0, 0}, "slip = \"free\"") + text::plane({0, 0, 0}, {0, 0, 1}, "slip = \"free\""));
    const auto n = static_cast<double>(positions(s).size());
    run_until(s, 3);
    double radius = 0;
    for (const Vec3& x : positions(s))
        radius = std::max(radius, std::hypot(static_cast<double>(x.x()), static_cast<double>(x.z())) + d / 2);
    const RoundSlump law(tau_y, weight, 4 * n * d * d * d);
    CHECK(radius == Approx(law.radius).epsilon(0.1));
    CHECK(mean_of(s, [](const Vec3d& x, const Vec3d&) { return x.y(); }) == Approx(law.centre).epsilon(0.1));
}

TEST_CASE("walls of mud and ketchup in 2D spread to the length and height of slumps with stress along the flow within 10 %",
          "[validation][yield]") {
    // Half of each. Fluid that yields throughout its depth, with tau = tau_y (1 - y/h), pulls along the flow by sigma_x - sigma_y = 2
    // sqrt(tau_y^2 - tau^2), pi/2 tau_y h over the depth. With the friction tau_y of the ground, rho g h^2/2 - pi/2 tau_y h = tau_y (L -
    // x). Measured: mud 7 %, ketchup 2 %.
    struct Case {
        double d, width, height;
        std::string law;
    };
    const double tau_y = 30, l = tau_y / 9810, half_pi = std::numbers::pi / 2;
    for (const auto& [d, width, height, law] :
         {Case{3e-3, 0.05, 0.05, "viscosity = 3"}, Case{2e-3, 0.03, 0.06, "consistency = 20\nflow_index = 0.3"}}) {
        INFO(law);
        Simulation s = simulation_of(text::time(2) + text::domain({-0.06, 0}, {0.2, 0.1}) +
                                     text::fluid(d, 0, fmt::format("yield_stress = {}\n{}", tau_y, law)) + text::models("coupled") +
                                     text::block({0, 0}, {width, height}) + text::plane({0, 0}, {0, 1}) +
                                     text::plane({0, 0}, {1, 0}, "slip = \"free\""));
        const auto n = static_cast<double>(positions(s).size());
        run_until(s, 2);
        double front = 0, centre = 0;
        for (const Vec3& x : positions(s))
            front = std::max(front, static_cast<double>(x.x()) + d / 2), centre += static_cast<double>(x.y()) / n;
        double L = 0, area = 0, moment = 0;
        for (const double dx = 1e-5; area < n * d * d; L += dx) {
            const double h = l * (half_pi + std::sqrt(half_pi * half_pi + 2 * L / l));
            area += h * dx, moment += h * h / 2 * dx;
        }
        CHECK(front == Approx(L).epsilon(0.1));
        CHECK(centre == Approx(moment / area).epsilon(0.1));
    }
}
