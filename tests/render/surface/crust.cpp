#include <catch2/catch.hpp>

#include "engine/core/random.h"
#include "render/surface/vertex_values.h"
#include "tests/support/shapes.h"

using namespace whorl;

namespace {

constexpr float d = 0.01f;

Frame frame_of(std::vector<Vec3f> position) {
    Frame frame;
    frame.spacing = d;
    frame.velocity.assign(position.size(), Vec3f(0, 0.1f, 0));
    frame.position = std::move(position);
    return frame;
}

}  // namespace

TEST_CASE("a vertex belongs to the plate whose edge is nearest, not whose middle is", "[render][surface]") {
    // Particles with a grain below 1/4.5^3 are middles. The largest grain makes the largest plate.
    const Frame frame = frame_of({Vec3f(0, 0, 0), Vec3f(2 * d, 0, 0), Vec3f(8 * d, 0, 0), Vec3f(30 * d, 0, 0)});
    const std::vector<float> grain{1e-4f, 0.5f, 0.0109f, 2e-3f};
    const Crust crust = crust_of(std::vector<Vec3f>{{d, 0, 0}, {3 * d, 0, 0}}, frame, grain);
    REQUIRE(crust.plate.size() == 3);
    CHECK(crust.plate[0].radius < 0.1f * d);
    CHECK(crust.plate[1].radius == Approx(6 * d).epsilon(0.05));
    CHECK(crust.plate[1].velocity == frame.velocity[2]);
    CHECK(crust.nearest[0] == std::array<float, 4>{0, 1, -1, -1});  // the last plate is out of reach
    CHECK(crust.nearest[1] == std::array<float, 4>{1, 0, -1, -1});
}

TEST_CASE("plates move with the fluid: after a translation every vertex has the same ones", "[render][surface]") {
    RandomNumbers random(3);
    std::vector<Vec3f> position = test::lattice(20, 20, 20, d), vertex;
    std::vector<float> grain(position.size());
    for (float& g : grain) g = static_cast<float>(random());
    for (int i = 0; i < 50; ++i) vertex.push_back(0.19f * Vec3f(static_cast<float>(random()), static_cast<float>(random()), 1));
    const Crust before = crust_of(vertex, frame_of(position), grain);
    const Vec3f way(0.25f, -0.125f, 0.5f);
    for (Vec3f& x : position) x += way;
    for (Vec3f& x : vertex) x += way;
    const Crust after = crust_of(vertex, frame_of(position), grain);
    CHECK(before.plate.size() > 50);  // 8000/4.5^3 = 88 in the mean
    int differ = 0;                   // two plates may be equally far but for rounding
    for (std::size_t v = 0; v < vertex.size(); ++v) differ += before.nearest[v] != after.nearest[v] ? 1 : 0;
    CHECK(differ <= 1);
}

TEST_CASE("without a particle as the middle of a plate there is no plate", "[render][surface]") {
    const Frame frame = frame_of(test::lattice(4, 4, 4, d));
    const Crust crust = crust_of(std::vector<Vec3f>{Vec3f::Zero()}, frame, std::vector<float>(64, 0.5f));
    CHECK(crust.plate.empty());
    CHECK(crust.nearest[0][0] == -1);
}
