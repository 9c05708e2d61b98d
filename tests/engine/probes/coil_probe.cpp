#include "engine/probes/coil_probe.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>
#include <sstream>

#include "engine/io/csv.h"

using namespace whorl;

namespace {

constexpr double pi = std::numbers::pi;

/// A steadily coiling thread of speed U on a pile that grows by one thread thickness per turn, as particles in a jittered filling of the
/// thread. The centre line, in axes that turn with the contact: s = 0 at the contact, q = s/L, radius R (1 - q^3)^2, slope sin^2(pi q/2):
/// as in the theory (Ribe 2004) the thread touches down horizontally, at rest, with the curvature 1/R of the previous turn. It is vertical
/// at s = L.
struct CoilingThread {
    double R = 0.0177, a = 0.0051, U = 0.25, d = 0.002, frequency = U / (2 * pi * R), noise = 0.2;
    double drift = 0;  ///< relative change of the frequency per second
    double side = 1;   ///< -1: turns the other way
    Vec3d axis = Vec3d::Zero();
    std::mt19937 random{7};

    double angle(double t) const { return 2 * pi * frequency * (t + drift * t * t / 2); }
    double turning(double t) const { return 2 * pi * frequency * (1 + drift * t); }
    /// Height of the upper side of the last turn; the ground below it is 2 a lower.
    double pile(double t) const { return 0.01 + 2 * a * angle(t) / (2 * pi); }
    double ground(double t) const { return pile(t) - 2 * a; }

    World at(double t) {
        World world;
        world.fluid.declare(field_info<field::position>(), true);
        world.fluid.declare(field_info<field::velocity>(), true);
        world.step.spacing = static_cast<Real>(d);
        std::vector<Vec3> x, u;
        const double L = 2.5 * R, phase = angle(t), ground = pile(t) - a;  // height of the centre line at the contact
        const auto put = [&](const Vec3d& centre, const Vec3d& tangent, const Vec3d& velocity) {
            const Vec3d n = tangent.unitOrthogonal(), b = tangent.cross(n);
            std::uniform_real_distribution<double> jitter(-noise * d, noise * d);
            for (double p = -a; p <= a; p += d)
                for (double q = -a; q <= a; q += d)
                    if (p * p + q * q <= a * a) {
                        const Vec3d at = centre + p * n + q * b + Vec3d(jitter(random), jitter(random), jitter(random));
                        x.push_back((axis + Vec3d(at.x(), at.y(), side * at.z())).cast<Real>());
                        u.push_back(Vec3d(velocity.x(), velocity.y(), side * velocity.z()).cast<Real>());
                    }
        };
        // The thread in the air, from the contact upwards. Material moves against s, from above.
        double phi = 0, z = 0;
        for (double s = 0; s < L + 0.03; s += d) {
            const double q = std::min(1.0, s / L), r = R * std::pow(1 - q * q * q, 2), dr = -6 * R * q * q / L * (1 - q * q * q);
            const double dz = std::sqrt(1 - dr * dr) * std::pow(std::sin(pi / 2 * q), 2),
                         along = std::sqrt(std::max(0.0, 1 - dr * dr - dz * dz));
            const Vec3d radial(std::cos(phase + phi), 0, std::sin(phase + phi)), context(-std::sin(phase + phi), 0, std::cos(phase + phi));
            const Vec3d tangent = dr * radial + along * context + dz * Vec3d::UnitY();
            // velocity in the laboratory frame: along the thread, and rotating with it (at rest when laid: U = turning R at the contact)
            const double speed = turning(t) * R + (U - turning(t) * R) * q;
            put(r * radial + (ground + z) * Vec3d::UnitY(), tangent, -speed * tangent + turning(t) * r * context);
            phi += along * d / std::max(r, 0.2 * R);
            z += dz * d;
        }
        // The pile at rest: turns already laid, behind the contact.
        for (double s = d; s < 2 * pi * R * 4; s += d) {
            const double laid = phase - s / R, y = ground - 2 * a * s / (2 * pi * R);
            if (y < 0) break;
            put(Vec3d(R * std::cos(laid), y, R * std::sin(laid)), Vec3d(-std::sin(laid), 0, std::cos(laid)), Vec3d::Zero());
        }
        world.fluid.resize(static_cast<Index>(x.size()));
        std::copy(x.begin(), x.end(), world.fluid.column<field::position>().begin());
        std::copy(u.begin(), u.end(), world.fluid.column<field::velocity>().begin());
        return world;
    }
};

ProbeKeys upright_axis() {
    ProbeKeys keys;
    keys.kind = ProbeKind::coil;
    return keys;
}

/// The last row of a probe that watches the thread to the end [s].
std::vector<double> watched(CoilingThread& thread, double end, const ProbeKeys& keys = upright_axis()) {
    CoilProbe probe(keys);
    double t = 0;
    for (; t < end; t += 0.004) probe.after_step(thread.at(t), t);
    return probe.rows(thread.at(t), t).front();
}

}  // namespace

TEST_CASE("the coil probe measures frequency and radius within 2 %, with jitter of a fifth of the spacing", "[io][probe]") {
    CoilingThread thread;
    REQUIRE(std::isnan(watched(thread, 0)[1]));
    const std::vector<double> row = watched(thread, 2.5);
    const double t = row[0];
    CHECK(row[1] == Approx(thread.frequency).epsilon(0.02));
    CHECK(row[2] == Approx(thread.R).epsilon(0.02));
    CHECK(row[3] == Approx(thread.frequency * t).margin(0.25));
    CHECK(row[4] < 0.02 * thread.frequency);
    CHECK(row[5] < 0.02 * thread.R);
    CHECK(row[6] == Approx(thread.ground(t)).margin(1.5 * thread.d));
    CHECK(row[7] == Approx(row[4] / 2));
    CHECK(row[8] == Approx(row[5] / 2));
}

// The mean over the last four turns refers to the ground about two turns ago, so the fall is longer by two turns' growth of the pile, 4 a.
// The growth of the pile within the probe's range of speeds, and the layers, contribute an error of a spacing each.
TEST_CASE("the coil probe's fall reaches from the thread's top to its last ground, within 2 spacings", "[io][probe]") {
    CoilingThread thread;
    CoilProbe probe(upright_axis());
    double t = 0;
    for (; t < 4.2 / thread.frequency; t += 0.004) probe.after_step(thread.at(t), t);
    const World world = thread.at(t);
    Real top = 0;
    for (const Vec3& x : world.fluid.column<field::position>()) top = std::max(top, x.y());
    const auto row = probe.rows(world, t).front();
    CHECK(row[9] == Approx(top - thread.ground(t) + 2 * thread.a * 2.2).margin(2 * thread.d));
}

// If the thread has a radius of 1.5 particles, or every particle is displaced by half a spacing, the mean of a slice is accurate to
// d/sqrt(7), of a turn to a tenth of that. 4 % covers the probe's ranges of one or two particles each.
TEST_CASE("few particles, noise, reversal or an axis off centre change frequency and radius by at most 4 %", "[io][probe]") {
    CoilingThread thread;
    SECTION("1.5 particles across the radius") { thread.d = thread.a / 1.5; }
    SECTION("particles displaced by half a spacing") { thread.noise = 0.5; }
    SECTION("clockwise") { thread.side = -1; }
    double missed = 0.5;  // turns
    SECTION("with an axis half a radius off, the coil's centre is found after one or two turns") {
        thread.axis = Vec3d(0.5 * thread.R, 0, 0);
        missed = 2;
    }
    SECTION("a coil no wider than two threads") {
        thread.R = 2 * thread.a;
        thread.frequency = thread.U / (2 * pi * thread.R);
    }
    const std::vector<double> row = watched(thread, 6.2 / thread.frequency);
    CHECK(row[1] == Approx(thread.frequency).epsilon(0.04));
    CHECK(row[2] == Approx(thread.R).epsilon(0.04));
    CHECK(row[3] == Approx(thread.frequency * row[0]).margin(missed));
}

TEST_CASE("with a height the coil probe measures the falling thread's radius at that height", "[io][probe]") {
    CoilingThread thread;
    ProbeKeys keys = upright_axis();
    keys.height = 5e-3;
    const std::vector<double> row = watched(thread, 2.5, keys);
    CHECK(row[1] == Approx(thread.frequency).epsilon(0.02));
    CHECK(row[2] < thread.R);
    CHECK(row[2] > 0.3 * thread.R);
    CHECK(row[6] == Approx(thread.ground(row[0])).margin(1.5 * thread.d));
}

// Without the low-pass of the pile's top, the section would be measured 3 radii higher in these steps.
TEST_CASE("a drop that rests above the pile in every twentieth step changes frequency and radius by at most 4 %", "[io][probe]") {
    CoilingThread thread;
    ProbeKeys keys = upright_axis();
    keys.height = 5e-3;
    const std::vector<double> without = watched(thread, 2.5, keys);
    CoilProbe probe(keys);
    double t = 0;
    for (int k = 0; t < 2.5; ++k, t += 0.004) {
        World world = thread.at(t);
        const Index first = world.fluid.size();
        if (k % 20 == 19) world.fluid.resize(first + 40);
        for (Index i = first; i < world.fluid.size(); ++i)
            world.fluid.column<field::position>()[i] = Vec3(Real(0.1), static_cast<Real>(thread.pile(t) + 3 * thread.a), 0);
        probe.after_step(world, t);
    }
    const auto row = probe.rows(thread.at(t), t).front();
    CHECK(row[1] == Approx(without[1]).epsilon(0.04));
    CHECK(row[2] == Approx(without[2]).epsilon(0.04));
    CHECK(row[3] == Approx(without[3]).margin(0.25));
}

TEST_CASE("a circle is found from points on any part of it that is more than a third, to rounding", "[io][probe]") {
    CirclePoints points;
    for (double angle = 0; angle < 2.2; angle += 0.1) points.add(1, 0.3 + 0.02 * std::cos(angle), -0.1 + 0.02 * std::sin(angle));
    REQUIRE(points.radius());
    CHECK(*points.radius() == Approx(0.02).epsilon(1e-6));
    CirclePoints line;
    for (double s = 0; s < 1; s += 0.1) line.add(1, s, 2 * s);
    CHECK_FALSE(line.radius());
}

TEST_CASE("an accelerating coil shows in the spread of its turns", "[io][probe]") {
    CoilingThread thread;
    thread.drift = 0.1;
    const std::vector<double> row = watched(thread, 2.5);
    CHECK(row[1] == Approx(thread.frequency * (1 + thread.drift * (row[0] - 0.9))).epsilon(0.03));
    CHECK(row[4] > 0.02 * thread.frequency);
}

TEST_CASE("a folding thread has no frequency, and its folds are not counted once it coils", "[io][probe]") {
    CoilingThread thread;
    CoilProbe probe(upright_axis());
    double t = 0;
    for (; t < 1.5; t += 0.01) probe.after_step(thread.at(0.5 + 0.15 * std::sin(2 * pi * t)), t);  // back and forth by 0.67 of a turn
    CHECK(std::isnan(probe.rows(thread.at(0.5), t).front()[1]));
    for (; t < 3; t += 0.01) probe.after_step(thread.at(t - 1), t);
    const auto row = probe.rows(thread.at(t - 1), t).front();
    CHECK(row[1] == Approx(thread.frequency).epsilon(0.05));
}

TEST_CASE("the coil probe continues bit-identically from its saved state", "[io][probe]") {
    CoilingThread thread;
    CoilProbe whole(upright_axis()), first(upright_axis()), second(upright_axis());
    double t = 0;
    for (; t < 0.8; t += 0.01) {
        const World world = thread.at(t);
        whole.after_step(world, t);
        (t < 0.4 ? first : second).after_step(world, t);
        if (t < 0.4 && t + 0.01 >= 0.4) {
            std::stringstream state;
            first.save(state);
            second.load(state);
        }
    }
    CHECK(csv_lines(whole.rows(thread.at(t), t)) == csv_lines(second.rows(thread.at(t), t)));
}

TEST_CASE("without a thread, or before it lands, the coil probe leaves its cells empty", "[io][probe]") {
    CoilingThread thread;
    CoilProbe probe(upright_axis());
    World world = thread.at(0);
    for (Vec3& v : world.fluid.column<field::velocity>()) v = Vec3::Zero();
    probe.after_step(world, 0.1);
    for (Vec3& v : world.fluid.column<field::velocity>()) v = Vec3(0, -1, 0);
    probe.after_step(world, 0.2);
    CHECK(csv_lines(probe.rows(world, 0.2)) == "0.2,,,0,,,0,,,,,\n");
}
