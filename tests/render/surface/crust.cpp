#include <catch2/catch.hpp>
#include <cmath>

#include "engine/core/random.h"
#include "render/surface/vertex_values.h"
#include "tests/support/shapes.h"

using namespace whorl;

namespace {

constexpr float d = 0.01f;

/// A block of particles d apart with grain 0.5, which makes no plate.
struct Fluid {
    std::vector<Vec3f> position;
    std::vector<float> grain;
};
Fluid block(int n) { return {test::lattice(n, n, n, d), std::vector<float>(static_cast<std::size_t>(n * n * n), 0.5f)}; }

}  // namespace

TEST_CASE("two plates meet half-way between their centres, with the distance to that edge in d", "[render][surface]") {
    Fluid fluid = block(4);
    fluid.position = {Vec3f(0, 0, 0), Vec3f(8 * d, 0, 0), Vec3f(2 * d, 5 * d, 0)};
    fluid.grain = {1e-3f, 2e-3f, 0.5f};
    const std::vector<Vec3f> vertex{{4 * d, 2 * d, 0}, {3 * d, -d, 2 * d}, {7 * d, 0, 0}, {0, 0, 0}};
    const auto places = crust_places(vertex, fluid.position, fluid.grain, d);
    const float expected[] = {0, 1, 3, 4};  // linear in x, with slope 1
    for (int v = 0; v < 4; ++v) CHECK(places[v][0] == Approx(expected[v]).margin(1e-4));
    CHECK(places[1][2] == places[3][2]);  // the same plate
    CHECK(places[1][2] != places[2][2]);
}

TEST_CASE("plates move with the fluid: after a translation every vertex has the same distance", "[render][surface]") {
    Fluid fluid = block(20);
    RandomNumbers random(3);
    for (float& g : fluid.grain) g = static_cast<float>(random());
    std::vector<Vec3f> vertex, moved_vertex, moved;
    const Vec3f way(0.3f, -0.1f, 0.2f);
    for (int i = 0; i < 50; ++i) vertex.push_back(0.19f * Vec3f(static_cast<float>(random()), static_cast<float>(random()), 1));
    for (const Vec3f& x : vertex) moved_vertex.push_back(x + way);
    for (const Vec3f& x : fluid.position) moved.push_back(x + way);
    const auto before = crust_places(vertex, fluid.position, fluid.grain, d), after = crust_places(moved_vertex, moved, fluid.grain, d);
    double widest = 0;
    for (std::size_t v = 0; v < vertex.size(); ++v) {
        for (int k = 0; k < 4; ++k) CHECK(before[v][k] == Approx(after[v][k]).margin(2e-3));  // rounding of places near 0.4 m
        widest = std::max(widest, static_cast<double>(before[v][0]));
    }
    CHECK(widest > 1);  // plates are seven spacings wide in the mean
    CHECK(widest < 7);
}

TEST_CASE("without a particle as plate centre there is no edge", "[render][surface]") {
    const Fluid fluid = block(4);
    const auto places = crust_places(std::vector<Vec3f>{Vec3f::Zero()}, fluid.position, fluid.grain, d);
    CHECK(places[0][0] > 5);
}
