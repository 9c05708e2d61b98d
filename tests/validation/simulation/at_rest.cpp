/// Fluid at rest between the solids of a scene: read, plan, simulate.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <numeric>

#include "engine/io/diagnostics.h"
#include "engine/models/pressure/constraint.h"
#include "tests/support/runs.h"
#include "tests/support/scene_text.h"

using namespace whorl;
using namespace whorl::test;

namespace at_rest_test {

namespace {

constexpr double d = 0.01, g = 9.81, rho_0 = 1000;

/// Water of this depth: "column" (periodic sideways), "slot" (between two walls, periodic along them), "gap" (under a ceiling, periodic
/// sideways), "open box", "full box".
struct Vessel {
    std::string kind;
    double spacing = d, width = 0.06, depth = 0.15;  ///< m
    int dimensions = 3;
    bool has_lid() const { return kind == "gap" || kind == "full box"; }
};

std::string scene_of(const Vessel& v, const std::string& time, const std::string& models, const std::string& sampling = "lattice") {
    const auto at = [&](double x, double y, double z) { return text::point(v.dimensions, x, y, z); };
    const bool box = v.kind.ends_with("box"), walls = box || v.kind == "slot";
    const double x = walls ? 0.05 : 0, z = box ? 0.05 : 0, top = v.has_lid() ? v.depth : v.depth + 0.1;
    const text::Point low = at(0, 0, 0), up = at(0, 1, 0);
    std::string solids = box ? text::tank(low, at(v.width, top, v.width)) : text::plane(low, up);
    if (v.kind == "gap") solids += text::plane(at(0, top, 0), at(0, -1, 0));
    if (v.kind == "slot") solids += text::plane(low, at(1, 0, 0)) + text::plane(at(v.width, 0, 0), at(-1, 0, 0));
    return text::time(100, time) +
           text::domain(at(-x, -0.05, -z), at(v.width + x, v.depth + 0.2, v.width + z),
                        fmt::format("periodic = [{}, false, {}]", !walls, !box && v.dimensions == 3)) +
           text::fluid(v.spacing) + models + text::block(low, at(v.width, v.depth, v.width), fmt::format("sampling = \"{}\"", sampling)) +
           solids;
}

/// Pressure of the lower half of the settled water over the weight of the water above it. Under a lid, which leaves the pressure without a
/// zero: its excess over the upper half.
class Weight {
public:
    explicit Weight(bool lid) : lid_(lid) {}
    void sample(const World& world) {
        const auto x = world.fluid.column<field::position>();
        const auto p = world.fluid.column<field::pressure>();
        double pressure[2] = {0, 0}, height[2] = {0, 0}, level = 0;
        int count[2] = {0, 0};
        for (const Vec3& one : x) level += 2 * static_cast<double>(one.y()) / static_cast<double>(x.size());
        for (std::size_t i = 0; i < x.size(); ++i) {
            const int upper = x[i].y() > Real(level / 2);
            pressure[upper] += p[i], height[upper] += x[i].y(), ++count[upper];
        }
        found_ += pressure[0] / count[0] - (lid_ ? pressure[1] / count[1] : 0);
        exact_ += rho_0 * g * ((lid_ ? height[1] / count[1] : level) - height[0] / count[0]);
    }
    double ratio() const { return found_ / exact_; }

private:
    bool lid_;
    double found_ = 0, exact_ = 0;
};

struct Settled {
    Vessel vessel;
    std::string models;
    double from, until;     ///< s
    double tolerance;       ///< of the weight
    double fastest = 0.02;  ///< bound of the largest speed, over sqrt(2 g depth)
    std::string sampling = "lattice";
    double max_step = 2e-3;
};

void keeps_its_weight(const Settled& s) {
    INFO(s.models << s.vessel.kind << " in " << s.vessel.dimensions << " dimensions, spacing " << s.vessel.spacing << ", " << s.sampling);
    Simulation simulation = simulation_of(scene_of(s.vessel, fmt::format("max_step = {}", s.max_step), s.models, s.sampling));
    run_until(simulation, s.from);
    Weight weight(s.vessel.has_lid());
    double fastest = 0;
    while (simulation.time() < s.until) {  // pressures are known at frame times
        run_until(simulation, simulation.time() + 0.005);
        weight.sample(simulation.world());
        fastest = std::max(fastest, largest_speed(velocities(simulation)));
    }
    CHECK(weight.ratio() == Approx(1).epsilon(s.tolerance));
    CHECK(fastest < s.fastest * std::sqrt(2 * g * s.vessel.depth));
    CHECK(simulation.totals().lost_particles == 0);
}

const std::string wcsph = text::models("wcsph"), ppe = text::models("ppe"), xsph = "viscosity = \"xsph\"\n[viscosity]\nalpha = 0.05\n",
                  density_source = text::pressure_form("projection") + "source = \"density\"\n";

}  // namespace

TEST_CASE("still water presses with its weight: wcsph and in 2D 2 %, a column 1 %, a slot of six spacings 2.5 %",
          "[validation][sim][plane][regression]") {
    // Single layers scatter by 2 %: the pressure of a settled packing depends on the direction, and the measured pressure is the mean over
    // layers. In the slot two of three particles are next to a wall: 2.0 to 2.2 % (1 % was aimed at).
    const Vessel flat{"open box", 0.0075, 0.06, 0.15, 2};
    for (const Settled& one : {Settled{{"gap"}, wcsph, 0.4, 0.6, 0.02, 0.02, "blue_noise"},
                               Settled{{"column", d, 0.06, 0.2}, ppe, 0.8, 1.0, 0.01, 0.05, "lattice", 5e-3},
                               Settled{{"slot", d, 0.06, 0.2}, ppe, 0.8, 1.0, 0.025, 0.05, "lattice", 5e-3},
                               Settled{flat, ppe, 0.6, 0.9, 0.02, 0.05}, Settled{flat, wcsph, 0.6, 0.8, 0.02}})
        keeps_its_weight(one);
}

TEST_CASE("wcsph: water from any start, and columns of 30 layers, press with their weight within 2 %", "[validation][sim][long]") {
    for (const double spacing : {0.01, 0.0075})
        for (const std::string kind : {"open box", "gap"})
            for (const std::string sampling : {"lattice", "blue_noise"})
                keeps_its_weight({{kind, spacing}, wcsph, 1, 1.2, 0.02, 0.02, sampling});
    for (const std::string& models : {wcsph, ppe + xsph}) keeps_its_weight({{"column", d, 0.06, 0.3}, models, 1, 1.2, 0.02});
}

namespace {

void published_rest(const std::string& kind, double correction) {
    // 2 s from a lattice, without viscosity. The energy that the melting lattice releases (0.2 to 0.6 % of m g H) dissipates. The only
    // other source of work is the uneven start, which a share of 1 corrects in one step (2e-4 of m g H). Remaining motion: 4e-6 to 6e-5.
    // The pressure over the last second: 0.7 % too low to 1.2 % too high (1 % was aimed at): the pressure of a settled packing depends on
    // the direction.
    INFO(kind << ", correction " << correction);
    Vessel vessel{kind, 0.0125, 6 * 0.0125, 12 * 0.0125};
    if (kind == "slot") vessel.width = 5 * 0.0125;
    Simulation simulation =
        simulation_of(scene_of(vessel, "max_step = 2e-3", density_source + fmt::format("correction = {}\n", correction)));
    // Energies over m g H.
    const auto energy = [&] {
        return mean_of(simulation, [&](const Vec3d& x, const Vec3d& u) { return (u.squaredNorm() / 2 / g + x.y()) / vessel.depth; });
    };
    const double start = energy();
    double highest = 0;
    Weight weight(vessel.has_lid());
    run_until(simulation, 2, [&] {
        highest = std::max(highest, energy() - start);
        if (simulation.time() >= 1) weight.sample(simulation.world());
    });
    const double moving = mean_square_speed(simulation) / 2 / (g * vessel.depth);
    CAPTURE(moving, largest_speed(velocities(simulation)) / std::sqrt(g * vessel.depth), highest);
    CHECK(highest < 3e-4 * correction);
    CHECK(moving < 5e-4);
    CHECK(weight.ratio() == Approx(1).epsilon(0.015));
    CHECK(simulation.totals().lost_particles == 0);
    CHECK(simulation.totals().unconverged_solves == 0);
}

}  // namespace

TEST_CASE("pressure.source density: still water gains no energy and presses with its weight within 1.5 %", "[validation][sim]") {
    published_rest("open box", 1);
    published_rest("slot", 0.1);
}

TEST_CASE("pressure.source density: either share of the density error per step has the same bounds", "[validation][sim][long]") {
    for (const std::string kind : {"column", "open box", "full box", "slot"})
        for (const double correction : {0.1, 1.0}) published_rest(kind, correction);
}

TEST_CASE("pressure.source density: water between floor and ceiling rests with the pressure of its weight", "[validation][sim]") {
    // Within 1 %. No free surface: the pressure has no natural zero. The ceiling must mirror the pressure less the weight up to it, or the
    // topmost layer falls (the run diverged within 0.2 s). Checked until the lattice, which is not a stable packing, starts to melt (0.3
    // s).
    keeps_its_weight({{"gap", d, 0.1, 0.1}, density_source, 0.1, 0.2, 0.01, 0.002});
}

namespace {

struct Rest {
    double early, late;       ///< root mean square speed over sqrt(2 g H), mean over 0.4 to 0.6 s and over the last 0.2 s
    double fastest;           ///< largest speed over sqrt(2 g H), mean over the last 0.2 s
    double density, densest;  ///< largest mean and largest single relative density error over the last 0.2 s
    bool keeps_densities;     ///< the form bounds them
    long lost;
};

/// Water in the vessel, from a lattice, for `end` seconds.
Rest settle(const Vessel& vessel, const std::string& viscosity, double end, double max_step = 5e-3) {
    Simulation simulation = simulation_of(scene_of(vessel, fmt::format("max_step = {}", max_step), ppe + viscosity));
    const double scale = std::sqrt(2 * g * vessel.depth);
    int steps = 0;
    Rest rest{};
    rest.keeps_densities = simulation.plan().traits.pressure.form == PressureForm::constraint;
    run_until(simulation, 0.4);
    run_until(simulation, 0.6, [&] { rest.early += mean_square_speed(simulation), ++steps; });
    rest.early = std::sqrt(rest.early / steps) / scale;
    run_until(simulation, end - 0.2);
    steps = 0;
    run_until(simulation, end, [&] {
        ++steps;
        rest.late += mean_square_speed(simulation);
        rest.fastest += largest_speed(velocities(simulation)) / scale;
        double mean = 0;
        const auto rho = simulation.world().fluid.column<field::density>();
        for (Real one : rho) {
            const double error = std::max(0.0, static_cast<double>(one) / rho_0 - 1);
            mean += error / static_cast<double>(rho.size());
            rest.densest = std::max(rest.densest, error);
        }
        rest.density = std::max(rest.density, mean);
    });
    rest.late = std::sqrt(rest.late / steps) / scale;
    rest.fastest /= steps;
    rest.lost = simulation.totals().lost_particles;
    return rest;
}

void comes_to_rest(const Vessel& vessel, const std::string& viscosity, double end = 2.4, double max_step = 5e-3, double densest = 1e-2) {
    // A lattice is not a stable packing: it melts, and the energy released by its fall to a denser packing (1 % of the height) must
    // dissipate. Speeds in units of sqrt(2 g H): the root mean square below 0.7 % (0.2 to 0.4 % is reached), and falling: below half of
    // what it was at 0.5 s (0.7 to 2 %, by when the lattice melts). Single particles that find a better place jump: the fastest of 1000, 1
    // to 3 % from run to run (float and double are two runs), below 5 %. The densest particle scatters in the same way (.02 to .3 %), the
    // mean does not.
    INFO(vessel.kind << (viscosity.empty() ? "" : ", XSPH") << ", spacing " << vessel.spacing);
    const Rest rest = settle(vessel, viscosity, end, max_step);
    CAPTURE(rest.early, rest.late, rest.fastest, rest.density, rest.densest);
    CHECK(rest.fastest < 0.05);
    CHECK(rest.late < 0.02 / 3);
    CHECK(rest.lost == 0);
    // Cases that fill their space without smoothing use the projection: it has no kernel sums, and its lattice does not melt.
    CHECK((rest.keeps_densities || vessel.kind != "open box"));
    if (!rest.keeps_densities) return;
    CHECK(rest.late < rest.early / 2);
    CHECK(rest.density < 1e-3);
    CHECK(rest.densest < densest);
}

const Vessel open_box{"open box", d, 0.1, 0.1}, full_box{"full box", d, 0.1, 0.1}, gap{"gap", d, 0.1, 0.1}, slot{"slot", d, 0.06, 0.2};

}  // namespace

TEST_CASE("a block of water at side walls stays at rest, and its corners have rho g depth within 5 %", "[validation][sim]") {
    // Walls show images where a probe asks for their forces, so the lattice next to them is held as inside: up to 7e-5 of its potential
    // energy moves while its excess of 0.09 % is corrected, 8e-7 after 0.1 s (9e-4 without images, when the force along walls was 0.84 of a
    // gradient's). Later the lattice melts. 2D: 1.04 in corners. 3D, 12 particles across: 1.02 in edges and corners (1.14 in corners
    // without images), 6e-8 to 5e-7 move.
    const bool plane = GENERATE(true, false);
    constexpr double spacing = 0.0125;
    const double width = plane ? 0.2 : 0.15;
    const auto at = [&](double x, double y, double z) { return text::point(plane ? 2 : 3, x, y, z); };
    Simulation simulation = simulation_of(text::time(2) + text::domain(at(-0.05, -0.05, -0.05), at(0.25, 0.3, 0.25)) +
                                          text::fluid(spacing) + ppe + text::block(at(0, 0, 0), at(width, width, width)) +
                                          text::tank(at(0, 0, 0), at(width, 0.3, width), "slip = \"free\"") +
                                          "[[probe]]\nname = \"tank\"\nkind = \"solid\"\nsolid = 0\n");
    double most = 0, corners = 0, exact = 0;
    run_until(simulation, 0.1, [&] { most = std::max(most, mean_square_speed(simulation) / (g * width)); });
    CHECK(most < 2e-4);
    for (int frame = 5; frame <= (plane ? 40 : 8); ++frame) {
        run_until(simulation, 0.05 * frame);
        const auto x = positions(simulation);
        const auto p = pressures(simulation);
        const auto outer = [&](Real where) { return std::abs(static_cast<double>(where) - width / 2) > width / 2 - spacing; };
        for (std::size_t i = 0; i < x.size(); ++i)
            if (x[i].y() < Real(spacing) && outer(x[i].x()) && (plane || outer(x[i].z())))
                corners += p[i], exact += rho_0 * g * (width - static_cast<double>(x[i].y()));
    }
    CHECK(corners / exact == Approx(1).epsilon(0.05));
}

namespace {

/// 16 x 16 particles of water in 2D, in a tank .2 m wide. @param time keys of [time] @param tank its solids
std::string square_of_water(const std::string& time, const std::string& tank) {
    return text::time(1, time) + text::domain({-0.05, -0.05}, {0.25, 0.3}) + text::fluid(0.0125) + ppe + text::block({0, 0}, {0.2, 0.2}) +
           tank;
}

}  // namespace

TEST_CASE("still water has rho g depth within 5 % at 99 of 100 frame times for any rhythm of steps", "[validation][sim]") {
    // Mean pressure of 16 x 16 particles over the weight's. The last steps before a frame are half as long as the others. A step that
    // leaves a residual shared by all particles gives .97 to 1.24 with steps of 2 and 1 ms, and .60 to 1.30 with 1 and .5 ms. Where
    // neighbours change places, a short step pushes harder: one frame of 330 has 1.057.
    struct Rhythm {
        double max_step, fps;
    };
    const Rhythm rhythm = GENERATE(Rhythm{5e-3, 200}, Rhythm{2e-3, 165}, Rhythm{1e-3, 165}, Rhythm{1e-3, 60});
    INFO("max_step " << rhythm.max_step << " fps " << rhythm.fps);
    Simulation simulation =
        simulation_of(square_of_water(fmt::format("max_step = {}", rhythm.max_step), text::tank({0, 0}, {0.2, 0.3}, "slip = \"free\"")));
    int frames = 0, off = 0;
    double farthest = 0;
    for (int frame = 1; frame < 0.7 * rhythm.fps; ++frame) {
        run_until(simulation, frame / rhythm.fps);
        if (frame < 0.2 * rhythm.fps) continue;
        const auto p = pressures(simulation);
        const double mean = std::accumulate(p.begin(), p.end(), 0.0) / static_cast<double>(p.size());
        const double error =
            std::abs(mean / mean_of(simulation, [](const Vec3d& x, const Vec3d&) { return rho_0 * g * (0.2 - x.y()); }) - 1);
        ++frames, off += error > 0.05, farthest = std::max(farthest, error);
    }
    CHECK(off <= frames / 80);
    CHECK(farthest < 0.08);
}

TEST_CASE("a tank of boxes, thin or thick, holds still water as calm as one container", "[validation][sim]") {
    // K/P is 1e-7 as in a container. If coinciding faces, or the far edges of a thin box, made wrong images, it would be 1e-4 to 3e-4.
    const double wall = GENERATE(0.025, 0.05);
    Simulation simulation = simulation_of(square_of_water(
        "", text::box({-wall, -wall}, {0.2 + wall, 0}) + text::box({-wall, 0}, {0, 0.3}) + text::box({0.2, 0}, {0.2 + wall, 0.3})));
    run_until(simulation, 0.1);
    const Measures now = measure(simulation.world(), Vec3d(0, -g, 0), 1);
    CHECK(now.kinetic_energy < 1e-5 * now.potential_energy);
    CHECK(now.density_error_max < 1e-3);
}

TEST_CASE("a deep tank in 2D stays calm when its first steps are short, on a lattice and jittered", "[validation][sim]") {
    // 100 layers, d = 1 cm, steps of 0.1 ms. The lattice is 0.09 % too dense in 2D, a jittered block about as much: corrected within a few
    // steps that threw the water up, at 4.5 m/s in the mean. The correction brings 3 % of sqrt(g L) + the mean speed to a length L =
    // 0.32 m of the fluid, so three times that to the surface, and half of it in the mean: 10 % of sqrt(g L) is twice the mean.
    for (const std::string sampling : {"lattice", "jittered"}) {
        INFO(sampling);
        Simulation simulation =
            simulation_of(text::time(1, "max_step = 1e-4") + text::domain({-0.05, -0.05}, {0.15, 1.3}) + text::fluid(0.01) +
                          text::block({0, 0}, {0.1, 1}, fmt::format("sampling = \"{}\"", sampling)) + text::tank({0, 0}, {0.1, 1.2}));
        double most = 0;
        for (int k = 1; k <= 20; ++k) {
            run_until(simulation, 1e-3 / 2 * k);
            most = std::max(most, mean_of(simulation, [](const Vec3d&, const Vec3d& u) { return u.y(); }));
        }
        CHECK(most < 0.1 * std::sqrt(g * 0.32));
    }
}

TEST_CASE("water that fills the gap between floor and ceiling lies still", "[validation][sim]") {
    // No free surface absorbs the density change from curved particle paths. Root mean square speed over sqrt(2 g H): 0.010, or 0.24 if the
    // pressure has to correct this change.
    const Rest rest = settle(gap, xsph, 1);
    CHECK(rest.early < 0.02);
    CHECK(rest.lost == 0);
}

TEST_CASE("water comes to rest between floor and ceiling, in a slot, in open and in full boxes", "[validation][sim][long]") {
    for (const std::string& viscosity : {std::string(), xsph})
        for (const Vessel& vessel : {open_box, full_box, gap, slot}) comes_to_rest(vessel, viscosity);
}

TEST_CASE("water in an open box comes to rest with half the spacing, and with steps of 1 ms", "[validation][sim][long]") {
    // Half the spacing settles faster, its lattice falls by half as much. Among 8000 particles the fastest reaches 4 %, the densest 3 % for
    // a moment.
    comes_to_rest({"open box", d / 2, 0.1, 0.1}, "", 1.2, 5e-3, 5e-2);
    comes_to_rest(open_box, "", 2.0, 1e-3, 5e-2);
}

TEST_CASE("water at rest has its pressure at every step within 5 %, at the default step and half of it", "[validation][sim]") {
    // The compression by gravity in a step is far less than the density error that a step may leave: a solve that stops there lets the
    // column fall for some steps and then stops it in one. Measured: 1.8 % and 1.9 % (12 and 22 % where the solve looked at the density
    // error alone). Mean over the lowest four layers.
    for (const double cfl : {0.4, 0.2}) {
        Simulation simulation = simulation_of(scene_of({"open box", 0.0125, 0.1, 0.2}, fmt::format("cfl = {}", cfl), ppe));
        run_until(simulation, 0.5);
        double off = 0;
        int steps = 0;
        run_until(simulation, 0.75, [&] {
            const auto x = positions(simulation);
            const auto p = simulation.world().fluid.column<field::constraint_pressure>();
            double sum = 0, exact = 0;
            for (std::size_t i = 0; i < x.size(); ++i)
                if (x[i].y() < 0.05) sum += p[i], exact += rho_0 * g * (0.2 - x[i].y());
            off += std::abs(sum / exact - 1), ++steps;
        });
        INFO("cfl " << cfl << ": " << off / steps);
        CHECK(off / steps < 0.05);
        CHECK(simulation.totals().unconverged_solves == 0);
    }
}

namespace {

/// Honey in a bucket of 48 mm that spins at 14/s from the first step on.
std::string spun_bucket(double spacing, double viscosity, const std::string& models = text::models("ppe", "full")) {
    const std::string round = "shape = \"cylinder\"\nfrom = [0, 0, 0]\nradius = 0.048\n";
    return text::time(20) + text::domain({-0.06, -0.01, -0.06}, {0.06, 0.12, 0.06}) + text::fluid(spacing, viscosity) + models +
           "[[block]]\n" + round + "to = [0, 0.036, 0]\n[[solid]]\n" + round +
           "to = [0, 0.11, 0]\ncontainer = true\nrotation = [0, 14, 0]\n";
}

double energy_of(const Simulation& simulation) {
    const Measures now = measure(simulation.world(), Vec3d(0, -g, 0), 1);
    return now.kinetic_energy + now.potential_energy;
}

/// Rigid rotation: z(r) = lowest + omega^2 r^2/(2 g). Its energy within `tolerance`, its surface at the highest particle within `margin`
/// [m].
void check_paraboloid(const Simulation& simulation, double spacing, double tolerance, double margin) {
    constexpr double R = 0.048, omega = 14;
    // Integrals over z, with the volume that the particles have.
    const double k = omega * omega / (2 * g),
                 level = measure(simulation.world(), Vec3d(0, -g, 0), 1).particles * std::pow(spacing, 3) / (std::numbers::pi * R * R),
                 lowest = level - k * R * R / 2,
                 kinetic = rho_0 * omega * omega * std::numbers::pi * (lowest * std::pow(R, 4) / 4 + k * std::pow(R, 6) / 6),
                 potential = rho_0 * g * std::numbers::pi *
                             (lowest * lowest * R * R + lowest * k * std::pow(R, 4) + k * k * std::pow(R, 6) / 3) / 2;
    CHECK(energy_of(simulation) == Approx(kinetic + potential).epsilon(tolerance));
    Vec3 highest = Vec3::Zero();
    for (const Vec3& x : simulation.world().fluid.column<field::position>())
        if (x.y() > highest.y()) highest = x;
    const double r = std::hypot(highest.x(), highest.z());
    CHECK(highest.y() + spacing / 2 == Approx(lowest + k * r * r).margin(margin));
}

}  // namespace

TEST_CASE("a bucket of honey that spins keeps the paraboloid and its energy", "[pressure][boundary]") {
    // The packing yields slowly: at 3 s the energy is 2.1 % below the exact one, 1.5 % with 6 mm.
    constexpr double spacing = 8e-3;
    Simulation simulation = simulation_of(spun_bucket(spacing, 4));
    simulation.count_energy();
    run_until(simulation, 2);
    const double before = energy_of(simulation);
    run_until(simulation, 3);
    const double now = energy_of(simulation);
    check_paraboloid(simulation, spacing, 0.03, spacing / 2);
    CHECK(now == Approx(before).epsilon(0.005));
    CHECK(std::abs(simulation.totals().work.error(now)) < 0.01 * now);
    CHECK(measure(simulation.world(), Vec3d(0, -g, 0), 1).density_error_mean < 1e-3);
}

TEST_CASE("coupled honey in a spinning bucket keeps the paraboloid within half a spacing, its energy within 1.5 %", "[coupled][boundary]") {
    // 6 spacings in the radius: .2 % at 3 s, the highest particle .2 spacings too high. If the hydrostatic pressure acted by its forces in
    // the rows: 1.7 %. If walls had the next step's velocities in the gradients before the solve: 6 %.
    constexpr double spacing = 8e-3;
    Simulation simulation = simulation_of(spun_bucket(spacing, 4, text::models("coupled")));
    run_until(simulation, 3);
    check_paraboloid(simulation, spacing, 0.015, spacing / 2);
}

TEST_CASE("a bucket's work on coupled honey is omega L within .5 %, and the heat never falls", "[coupled][boundary]") {
    // In rigid rotation the wall has no torque. If it did not receive the opposite of the load that replaces the pressure's forces, the
    // work would be 7 % too small at 3 s and fall; if shifts and contact took angular momentum, 5 % too large. The heat would fall by 2 %
    // if it contained the work of the pressure in moving crowded particles apart.
    Simulation simulation = simulation_of(spun_bucket(8e-3, 4, text::models("coupled")));
    simulation.count_energy();
    double heat = 0;
    for (int k = 1; k <= 12; ++k) {
        run_until(simulation, 0.25 * k);
        const EnergyBudget& work = simulation.totals().work;
        CHECK(work.solids == Approx(14 * measure(simulation.world(), Vec3d(0, -g, 0), 1).angular_momentum.y()).epsilon(0.005));
        CHECK(-work.viscosity >= heat);
        CHECK(std::abs(work.moves) < 0.01 * energy_of(simulation));
        heat = -work.viscosity;
    }
}

TEST_CASE("weakly compressible honey in a spinning bucket stays .4 spacings off its wall", "[wcsph][boundary]") {
    // Particles at the edge of the surface have no pressure: without the clearance they lie on the wall.
    constexpr double spacing = 8e-3;
    Simulation simulation = simulation_of(spun_bucket(spacing, 4, text::models("wcsph", "full")));
    run_until(simulation, 0.5);
    double nearest = spacing;
    for (const Vec3& x : simulation.world().fluid.column<field::position>())
        nearest = std::min(nearest, 0.048 - static_cast<double>(std::hypot(x.x(), x.z())));
    CHECK(nearest > 0.39 * spacing);
    check_paraboloid(simulation, spacing, 0.03, spacing / 2);
}

TEST_CASE("weakly compressible honey spun for 20 s has the energy of rigid rotation within .7 %", "[wcsph][boundary][long]") {
    // The packing yields slowly: the energy is .6 % below the exact one at 2 s, and .15 % below at 14 s. If particles could lie on the
    // wall, it would rise by 2.4 % in 8 s.
    constexpr double spacing = 8e-3;
    Simulation simulation = simulation_of(spun_bucket(spacing, 4, text::models("wcsph", "full")));
    for (const double t : {2, 4, 8, 12, 16, 20}) {
        run_until(simulation, t);
        check_paraboloid(simulation, spacing, 0.007, spacing / 2);
    }
}

TEST_CASE("honey spun for 20 s keeps its energy from 2 s on: within .5 % under ppe, 1 % under coupled",
          "[pressure][coupled][boundary][long]") {
    for (const bool coupled : {false, true}) {
        CAPTURE(coupled);
        const double spacing = coupled ? 8e-3 : 6e-3;
        Simulation simulation = simulation_of(coupled ? spun_bucket(spacing, 4, text::models("coupled")) : spun_bucket(spacing, 4));
        run_until(simulation, 2);
        const double before = energy_of(simulation);
        run_until(simulation, 3);
        if (!coupled) check_paraboloid(simulation, spacing, 0.02, spacing / 2);
        run_until(simulation, 20);
        check_paraboloid(simulation, spacing, 0.03, spacing / 2);
        CHECK(energy_of(simulation) == Approx(before).epsilon(coupled ? 0.01 : 0.005));
    }
}

TEST_CASE("honey of 50 Pa s does not climb a bucket that spins, and its energy in that frame falls", "[pressure][boundary]") {
    // With walls that move along straight lines in a step, it falls until 1 s and then rises.
    Simulation simulation = simulation_of(spun_bucket(8e-3, 50));
    simulation.count_energy();
    run_until(simulation, 0.1);  // the lattice next to the round wall has been separated
    const double moved = simulation.totals().work.moves;
    double last = std::numeric_limits<double>::infinity();
    for (int k = 1; k <= 6; ++k) {
        run_until(simulation, 0.3 * k);
        const Measures now = measure(simulation.world(), Vec3d(0, -g, 0), 1);
        const double energy = now.kinetic_energy + now.potential_energy - 14 * now.angular_momentum.y();
        CHECK(energy < last);
        CHECK(simulation.totals().work.moves < moved + 1e-5 * now.potential_energy);
        last = energy;
    }
}

}  // namespace at_rest_test
