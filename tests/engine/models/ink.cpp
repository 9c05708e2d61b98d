/// Passive colours that particles carry.
#include "engine/models/ink/ink.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "engine/core/random.h"
#include "tests/support/world.h"

using namespace whorl;
using namespace whorl::test;

namespace ink_test {

namespace {

constexpr double d = 0.01, diffusion = 2e-5;
constexpr int across = 32;

/// A periodic square, or a slab of 6 d, of particles up to `loose` d off their lattice.
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
            for (int k = 0; k < 20; ++k) w.step(time / 20);  // each is several times as long as one part may be
            const double rate = -std::log(amplitude(w) / first);
            INFO(dimensions << " dimensions, " << loose << " d off the lattice: rate " << rate);
            // On a lattice 0.1 % too slow, for the kernel flattens a wave of 32 d; on uneven particles 0.9 %.
            CHECK(rate == Approx(1).epsilon(0.015));
        }
}

TEST_CASE("ink that spreads is kept, and stays between the least and the most that there was", "[ink]") {
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

}  // namespace ink_test
