/// Passive colours that particles carry.
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "engine/core/random.h"
#include "engine/models/ink/ink_markers.h"
#include "tests/support/world.h"

using namespace whorl;
using namespace whorl::test;

namespace ink_test {

namespace {

constexpr double d = 0.01, diffusion = 2e-5;
constexpr int across = 32;

/// A periodic square or a slab 6 d thick, with particles up to `loose` d off their lattice.
TestWorld spreading(int dimensions, double loose) {
    const auto length = static_cast<Real>(across * d);
    const Vec3 end(length, length, dimensions == 2 ? Real(0) : static_cast<Real>(6 * d));
    TestWorld w(d, dimensions == 2 ? 3 : 2.5, Domain{Vec3::Zero(), end, {true, true, dimensions == 3}}, KernelKind::wendland_c2);
    w.use({make_stage("ink diffusion", "ink", InkDiffusion{diffusion})});
    w.place(Vec3::Zero(), end);
    RandomNumbers random(5);
    for (Vec3& x : w.column<field::position>())
        for (int a = 0; a < dimensions; ++a) x[a] += static_cast<Real>(loose * d * (2 * random() - 1));
    return w;
}

double wave_number() { return 2 * std::numbers::pi / (across * d); }

/// Amplitude of cos(k x) in the second ink.
double amplitude(TestWorld& w) {
    double sum = 0, norm = 0;
    const auto x = w.column<field::position>();
    const auto c = w.column<field::ink>();
    for (std::size_t i = 0; i < x.size(); ++i) {
        const double wave = std::cos(wave_number() * static_cast<double>(x[i].x()));
        sum += (static_cast<double>(c[i].y()) - 0.5) * wave, norm += wave * wave;
    }
    return sum / norm;
}

}  // namespace

TEST_CASE("a wave of ink decays as exp(-D k^2 t), in 2D and 3D, on a lattice and off it", "[ink]") {
    for (const int dimensions : {2, 3})
        for (const double loose : {0.0, 0.2}) {
            TestWorld w = spreading(dimensions, loose);
            const auto x = w.column<field::position>();
            const auto c = w.column<field::ink>();
            for (std::size_t i = 0; i < x.size(); ++i)
                c[i] = Vec3(0, static_cast<Real>(0.5 + 0.4 * std::cos(wave_number() * static_cast<double>(x[i].x()))), 0);
            const double first = amplitude(w), time = 1 / (diffusion * wave_number() * wave_number());
            for (int k = 0; k < 20; ++k) w.step(time / 20);  // each is several times the longest substep
            const double rate = -std::log(amplitude(w) / first);
            INFO(dimensions << " dimensions, " << loose << " d off the lattice: rate " << rate);
            // On a lattice 0.1 % too slow, for the kernel flattens a wave of 32 d; on uneven particles 0.9 %.
            CHECK(rate == Approx(1).epsilon(0.015));
        }
}

TEST_CASE("diffusing ink conserves its total and stays between its initial minimum and maximum", "[ink]") {
    TestWorld w = spreading(2, 0.3);
    const auto x = w.column<field::position>();
    const auto c = w.column<field::ink>();
    for (std::size_t i = 0; i < x.size(); ++i) c[i] = Vec3(x[i].x() < 0.1f ? 1 : 0, x[i].y() < 0.1f ? 0.5f : 1, 0);
    const auto total = [&] {
        Vec3d sum = Vec3d::Zero();
        for (const Vec3& one : c) sum += one.cast<double>();
        return sum;
    };
    const Vec3d before = total();
    for (int k = 0; k < 10; ++k) w.step(2);
    CHECK((total() - before).norm() < 1e-5 * before.norm());  // rounding of float
    for (const Vec3& one : c) {
        REQUIRE(one.x() >= -1e-6f);
        REQUIRE(one.x() <= 1 + 1e-6f);
        REQUIRE(one.y() >= 0.5f - 1e-6f);
        REQUIRE(one.z() == 0);
    }
}

namespace {

/// Particles that a map x -> x(t) moves in steps, and their markers.
struct Carried {
    const bool flat;
    TestWorld w;
    std::vector<Vec3> begin;  ///< positions of the markers at first

    explicit Carried(int dimensions)
        : flat(dimensions == 2), w(d, 2, Domain{Vec3(-1, -1, dimensions == 2 ? 0 : -1), Vec3(1, 1, dimensions == 2 ? 0 : 1), {}}) {
        w.use({make_stage("ink markers", "ink", MoveInkMarkers{})});
        const auto length = static_cast<Real>(across * d);
        w.place(Vec3::Zero(), Vec3(length, length, dimensions == 2 ? Real(0) : static_cast<Real>(6 * d)));
        RandomNumbers random(5);
        for (Vec3& p : w.column<field::position>())
            for (int a = 0; a < dimensions; ++a) p[a] += static_cast<Real>(0.3 * d * (2 * random() - 1));
        InkMarkers& markers = w.world.ink_markers;
        markers.per_spacing = 2;
        markers.store.declare(field_info<field::position>(), true), markers.store.declare(field_info<field::ink>(), true);
        const auto x = w.column<field::position>();
        std::copy(x.begin(), x.end(), w.column<field::path_start>().begin());
        markers.add(x, w.world.step);
        const auto ink = markers.store.column<field::ink>();
        for (std::size_t m = 0; m < ink.size(); ++m) ink[m].x() = static_cast<Real>(m);  // the order of the markers changes
        const auto place = markers.store.column<field::position>();
        begin.assign(place.begin(), place.end());
    }
    /// The next position of every particle, by the velocity over the step.
    template <class F>
    void step(bool frame, const F& next) {
        const auto x = w.column<field::position>();
        const auto u = w.column<field::velocity>();
        for (std::size_t i = 0; i < x.size(); ++i) u[i] = next(x[i]) - x[i], x[i] += u[i];
        w.world.step.dt = 1, w.world.step.to_frame_time = frame;
        for (Stage& stage : w.stages) stage.run(w.world);
    }
    struct Error {
        double largest = 0, square = 0;
        int markers = 0;
        double mean() const { return std::sqrt(square / markers); }
    };
    /// Distances of the markers that began within `inside` of the middle from where the map takes them [d].
    template <class F>
    Error error(const F& map, double inside) {
        const auto place = w.world.ink_markers.store.column<field::position>();
        const auto ink = w.world.ink_markers.store.column<field::ink>();
        Error error;
        for (std::size_t m = 0; m < place.size(); ++m) {
            const Vec3 from = begin[static_cast<std::size_t>(ink[m].x())];
            // Markers near the surface of the slab have particles on one side only.
            const bool deep = flat || std::abs(from.z() - static_cast<Real>(3 * d)) < d;
            if (!deep || (from - middle()).head<2>().norm() > inside) continue;
            const double off = static_cast<double>((place[m] - map(from)).norm()) / d;
            error.largest = std::max(error.largest, off), error.square += off * off, ++error.markers;
        }
        return error;
    }
    static Vec3 middle() { return Vec3(static_cast<Real>(across * d / 2), static_cast<Real>(across * d / 2), 0); }
};

}  // namespace

TEST_CASE("ink markers follow an affine motion exactly, in 2D and 3D, also between frames", "[ink]") {
    for (const int dimensions : {2, 3}) {
        Carried run(dimensions);
        Mat3 turn = Mat3::Identity();  // a rotation of .2 rad with stretching
        turn.topLeftCorner<2, 2>() << Real(1.1 * std::cos(0.2)), Real(-1.1 * std::sin(0.2)), Real(std::sin(0.2) / 1.1),
            Real(std::cos(0.2) / 1.1);
        const auto next = [&](const Vec3& x) -> Vec3 { return Carried::middle() + turn * (x - Carried::middle()); };
        for (int k = 0; k < 4; ++k) run.step(k % 2 == 1, next);
        const auto map = [&](const Vec3& x) { return next(next(next(next(x)))); };
        CHECK(run.w.world.ink_markers.store.size() > static_cast<Index>(0.99 * static_cast<double>(run.begin.size())));
        CHECK(run.error(map, 12 * d).largest <
              3e-3);  // round-off, .002 d measured; particles at the edge do not determine an affine motion
    }
}

TEST_CASE("ink markers follow a vortex over half a turn within .03 spacings in the mean", "[ink]") {
    Carried run(2);
    // Circles about the middle whose speed falls with the radius: particles a spacing apart shear past each other by 1.1 spacings at most.
    const auto turned = [](const Vec3& x, double share) -> Vec3 {
        const Vec3 r = x - Carried::middle();
        const double angle = share * std::numbers::pi * std::exp(-static_cast<double>(r.squaredNorm()) / (100 * d * d));
        const Real c = static_cast<Real>(std::cos(angle)), s = static_cast<Real>(std::sin(angle));
        return Carried::middle() + Vec3(c * r.x() - s * r.y(), s * r.x() + c * r.y(), r.z());
    };
    for (int k = 0; k < 20; ++k) run.step(true, [&](const Vec3& x) { return turned(x, 0.05); });
    const auto error = run.error([&](const Vec3& x) { return turned(x, 1); }, 11 * d);
    CHECK(error.mean() < 0.03);  // .023 measured; .07 without the second fit
    CHECK(error.largest < 0.2);  // .15 measured
}

TEST_CASE("ink markers of particles that fly apart keep finite positions near a particle", "[ink]") {
    Carried run(3);
    RandomNumbers random(7);
    const auto astray = [&](const Vec3& x) -> Vec3 {
        const auto along = [&] { return static_cast<Real>(1.5 * d * (2 * random() - 1)); };
        return x + Vec3(along(), along(), along());
    };
    for (int k = 0; k < 30; ++k) run.step(true, astray);
    const auto x = run.w.column<field::position>();
    double farthest = 0;  // a marker with a single particle in reach moves like it, others by a fit to few particles
    for (const Vec3& place : run.w.world.ink_markers.store.column<field::position>()) {
        REQUIRE(place.allFinite());
        Real nearest = std::numeric_limits<Real>::max();
        for (const Vec3& one : x) nearest = std::min(nearest, (one - place).norm());
        farthest = std::max(farthest, static_cast<double>(nearest) / d);
    }
    CHECK(farthest < 3.5);  // 1.75 spacings of reach, and as much by a fit to differing displacements
}

TEST_CASE("only particles without a marker near get new ones, with their own ink", "[ink]") {
    Carried run(2);
    InkMarkers& markers = run.w.world.ink_markers;
    NeighbourSearch search;
    const Index before = markers.store.size();
    const auto x = run.w.column<field::position>();
    std::vector<Vec3> place(x.begin(), x.end()), ink(x.size(), Vec3::Zero());
    markers.fill_gaps(run.w.world.step, place, ink, search);
    CHECK(markers.store.size() == before);
    place.emplace_back(Real(-0.5), 0, 0), ink.emplace_back(0, Real(0.25), 1);
    markers.fill_gaps(run.w.world.step, place, ink, search);
    REQUIRE(markers.store.size() == before + 4);  // two by two
    for (Index m = before; m < markers.store.size(); ++m) CHECK(markers.store.column<field::ink>()[m] == Vec3(0, Real(0.25), 1));
}

}  // namespace ink_test
