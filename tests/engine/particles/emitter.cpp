#include "engine/particles/emitter.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <numbers>
#include <sstream>

#include "engine/core/parallel.h"
#include "engine/particles/sample.h"
#include "engine/particles/search.h"

using namespace whorl;

namespace emitter_test {

namespace {

constexpr Real d = Real(0.002);

ParticleStore empty_store() {
    ParticleStore store;
    store.declare(field_info<field::position>(), true);
    store.declare(field_info<field::velocity>(), true);
    store.declare(field_info<field::role>(), true);
    return store;
}

EmitterShape nozzle(bool parabolic = false) {
    EmitterShape shape;
    shape.centre = Vec3(Real(0.01), Real(0.3), 0);
    shape.direction = -Vec3::UnitY();
    shape.radius = Real(0.005);
    shape.parabolic = parabolic;
    return shape;
}

/// Emits and moves particles with their emission velocity, in irregular steps.
void run(Emitter& emitter, ParticleStore& store, double end, double step, double& t) {
    int k = 0;
    while (t < end - 1e-12) {
        const double dt = std::min(end - t, step * (1 + 0.5 * (k++ % 3)));
        emitter.enter(store, t, dt);
        const auto x = store.column<field::position>();
        const auto u = store.column<field::velocity>();
        for (std::size_t i = 0; i < x.size(); ++i) x[i] += static_cast<Real>(dt) * u[i];
        t += dt;
        emitter.release(store, t);
    }
}

double nearest_pair(ParticleStore& store) {
    Domain open;
    Pairs pairs;
    NeighbourSearch search;
    search.find(std::as_const(store).column<field::position>(), 2 * d, open, pairs);
    double least = 1e9;
    for (Index i = 0; i < pairs.size(); ++i)
        pairs.of(i, [&](Index, const Vec3&, Real r) { least = std::min(least, static_cast<double>(r)); });
    return least;
}

/// Largest distance from a point of the free column's axis to the nearest particle.
double largest_gap(ParticleStore& store, const Emitter& emitter, double length) {
    double most = 0;
    for (double s = 0; s < length; s += 0.1 * d) {
        const Vec3 p = emitter.shape().centre + static_cast<Real>(s) * emitter.shape().direction;
        double least = 1e9;
        for (const Vec3& x : store.column<field::position>()) least = std::min(least, static_cast<double>((x - p).norm()));
        most = std::max(most, least);
    }
    return most;
}

}  // namespace

TEST_CASE("an emitter leaves no gaps and no close pairs, at any speed and time step", "[particles]") {
    // Steps from a fiftieth of a spacing to five layers at once.
    for (double speed : {0.1, 2.0})
        for (double dt : {4e-4, 5e-3}) {
            ParticleStore store = empty_store();
            Emitter emitter(nozzle(), Expression(speed), 0, 1e9, d, 4 * d, 1, 7);
            double t = 0;
            const double length = 0.1;
            run(emitter, store, length / speed, dt, t);
            INFO("speed " << speed << " dt " << dt);
            CHECK(nearest_pair(store) > 0.6 * d);
            CHECK(largest_gap(store, emitter, length - d) < 0.95 * d);
            Index free_particles = 0;
            for (std::int16_t role : store.column<field::role>()) free_particles += role == 0;
            // The column repeats blue noise of 24 spacings. Within a repeat the count fluctuates by a few particles at its ends.
            CHECK(free_particles == Approx(emitter.expected_particles()).margin(8));
        }
}

TEST_CASE("the mass flow of a plug is exact to one particle after whole repeats of the column", "[particles]") {
    ParticleStore store = empty_store();
    Emitter emitter(nozzle(), Expression(1.0), 0, 1e9, d, 4 * d, 1, 7);
    double t = 0;
    const double count = std::round(std::numbers::pi * 25e-6 * 24 * d / (d * d * d));
    const double length = count * d * d * d / (std::numbers::pi * 25e-6);
    run(emitter, store, 3 * length, 1e-3, t);
    Index free_particles = 0;
    for (std::int16_t role : store.column<field::role>()) free_particles += role == 0;
    CHECK(emitter.expected_particles() == Approx(3 * count).margin(0.01));
    CHECK(std::abs(free_particles - 3 * count) <= 1);
}

TEST_CASE("the column of a wide opening has one layer of a hundred thousand particles, not 24", "[particles]") {
    CHECK(column_points(100, 1, false, 3) == 2400);
    CHECK(column_points(100, 1, true, 3) == 100);
    CHECK(column_points(1e4, 1, false, 3) == 100000);
    CHECK(column_points(1e6, 1, false, 3) == 6e6);
}

TEST_CASE("a parabolic profile is twice as fast in the middle and makes no close pairs", "[particles]") {
    ParticleStore store = empty_store();
    Emitter emitter(nozzle(true), Expression(0.5), 0, 1e9, d, 4 * d, 1, 7);
    CHECK(emitter.speed(0) == Approx(1.0));
    double t = 0;
    run(emitter, store, 0.4, 2e-3, t);
    CHECK(nearest_pair(store) > 0.6 * d);
    Index free_particles = 0;
    for (std::int16_t role : store.column<field::role>()) free_particles += role == 0;
    // Few streamlines sample the profile: their mean factor is 1 within some per cent.
    CHECK(free_particles == Approx(emitter.expected_particles()).epsilon(0.06));
}

TEST_CASE("an emitter emits volume at its speed, and continues exactly from its saved state", "[particles]") {
    ParticleStore store = empty_store();
    const Expression speed("0.5*t");
    Emitter emitter(nozzle(), speed, 0.1, 0.5, d, 4 * d, 2, 7);
    double t = 0;
    run(emitter, store, 0.3, 3e-3, t);
    std::stringstream saved;
    emitter.save(saved);
    Emitter copy(nozzle(), speed, 0.1, 0.5, d, 4 * d, 2, 7);
    CHECK(copy.load(saved));
    std::string state = saved.str();
    const long never = std::numeric_limits<long>::min();
    state.replace(sizeof(double), sizeof never, reinterpret_cast<const char*>(&never), sizeof never);
    std::istringstream wrong(state);
    Emitter other_copy(nozzle(), speed, 0.1, 0.5, d, 4 * d, 2, 7);
    CHECK_FALSE(other_copy.load(wrong));
    ParticleStore other = empty_store();
    other.resize(store.size());
    std::ranges::copy(store.column<field::position>(), other.column<field::position>().begin());
    std::ranges::copy(store.column<field::role>(), other.column<field::role>().begin());
    std::ranges::copy(store.column<field::velocity>(), other.column<field::velocity>().begin());
    double t2 = t;
    run(emitter, store, 0.7, 3e-3, t);
    run(copy, other, 0.7, 3e-3, t2);
    REQUIRE(store.size() == other.size());
    for (std::size_t i = 0; i < static_cast<std::size_t>(store.size()); ++i)
        REQUIRE(store.column<field::position>()[i] == other.column<field::position>()[i]);
    const double volume = 0.25 * (0.25 - 0.01) * std::numbers::pi * 25e-6;  // integral of 0.5 t from 0.1 to 0.5
    CHECK(emitter.expected_particles() == Approx(volume / (d * d * d)).epsilon(1e-6));
    CHECK(emitter.speed(0.4) == Approx(0.2));
    for (const double outside : {0.09, 0.51}) CHECK(emitter.speed(outside) == 0);
}

TEST_CASE("a slot's column fills its opening", "[particles]") {
    EmitterShape slot;
    slot.slot = true;
    slot.width = 10 * d;
    slot.thickness = 3 * d;
    slot.direction = Vec3::UnitX();
    ParticleStore store = empty_store();
    Emitter emitter(slot, Expression(0.3), 0, 1e9, d, 4 * d, 1, 3);
    double t = 0;
    run(emitter, store, 0.2, 2e-3, t);
    CHECK(nearest_pair(store) > 0.6 * d);
    for (const Vec3& x : store.column<field::position>()) {
        CHECK(std::abs(x.z()) < 5 * d);  // horizontal width lies across the flow
        CHECK(std::abs(x.y()) < Real(1.5) * d);
    }
}

// Galilean invariance: seen from an opening in uniform motion, the flow is that of an opening at rest. Tolerance: a millionth of the path
// in single precision, over a hundred steps.
TEST_CASE("an opening in uniform motion emits the column of one at rest, carried along, to 0.01 spacings", "[particles]") {
    const Vec3d along(0.3, 0.1, -0.2);
    ParticleStore at_rest = empty_store(), moving = empty_store();
    Emitter fixed(nozzle(), Expression(0.5), 0, 1e9, d, 4 * d, 1, 7), carried(nozzle(), Expression(0.5), 0, 1e9, d, 4 * d, 1, 7);
    const EmitterShape& opening = fixed.shape();
    VectorExpression position, direction;
    for (int a = 0; a < 3; ++a) {
        position.component[a] = Expression(std::to_string(opening.centre[a]) + " + " + std::to_string(along[a]) + "*t");
        direction.component[a] = Expression(static_cast<double>(opening.direction[a]));
    }
    carried.follow(position, direction);
    double t = 0, t2 = 0;
    run(fixed, at_rest, 0.2, 2e-3, t);
    run(carried, moving, 0.2, 2e-3, t2);
    REQUIRE(moving.size() == at_rest.size());
    const auto x = at_rest.column<field::position>(), y = moving.column<field::position>(), u = at_rest.column<field::velocity>(),
               v = moving.column<field::velocity>();
    const auto role = at_rest.column<field::role>();
    for (std::size_t i = 0; i < x.size(); ++i) {
        CHECK((y[i] - x[i] - (t * along).cast<Real>()).norm() < Real(0.01) * d);
        if (role[i] == 0) CHECK((v[i] - u[i] - along.cast<Real>()).norm() < Real(1e-3));
    }
}

// A nozzle that turns in the plane about its opening. The pipe turns rigidly, so the particles in it stay in the pipe, and the fluid leaves
// along the direction at that moment with the velocity of the opening added.
TEST_CASE("an opening that turns and swings emits its volume along its direction, from a pipe that stays full", "[particles]") {
    ParticleStore store = empty_store();
    Emitter emitter(nozzle(), Expression(0.5), 0, 1e9, d, 4 * d, 1, 7);
    const double rate = 4, swing = 0.02;
    VectorExpression position, direction;
    position.component = {Expression("0.01 + 0.02*sin(4*t)"), Expression(0.3), Expression(0.0)};
    direction.component = {Expression("sin(4*t)"), Expression("-cos(4*t)"), Expression(0.0)};
    emitter.follow(position, direction);
    double t = 0;
    run(emitter, store, 0.3, 2e-3, t);
    const Vec3d way(std::sin(rate * t), -std::cos(rate * t), 0), own(swing * rate * std::cos(rate * t), 0, 0);
    CHECK((emitter.shape().direction.cast<double>() - way).norm() < 1e-6);
    CHECK((emitter.pose().velocity_at(emitter.shape().centre).cast<double>() - own).norm() < 1e-3);
    const auto x = store.column<field::position>(), u = store.column<field::velocity>();
    const auto role = store.column<field::role>();
    Index in_pipe = 0, released = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        const Vec3d r = (x[i] - emitter.shape().centre).cast<double>();
        const double along = r.dot(way);
        if (role[i] == 0) {
            ++released;
            if (along < 0.5 * d && (r - along * way).norm() < 2 * d)  // just released: 0.5 m/s along, and the opening's velocity
                CHECK((u[i].cast<double>() - 0.5 * way - own).norm() < 0.05);
            continue;
        }
        ++in_pipe;
        CHECK((r - along * way).norm() < 0.005 + 1e-4);  // in the pipe
        CHECK(along < 1e-6);
    }
    const double in_depth = std::numbers::pi * 25e-6 * 4 * d / (d * d * d);
    CHECK(in_pipe == Approx(in_depth).epsilon(0.1));
    CHECK(released == Approx(emitter.expected_particles()).margin(8));
}

}  // namespace emitter_test
