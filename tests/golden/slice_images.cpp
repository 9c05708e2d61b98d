/// Slices of flows given by formulas. They need no graphics device.
#include <cmath>

#include "engine/core/random.h"
#include "render/flow/slice.h"
#include "tests/golden/stored.h"
#include "tests/support/shapes.h"

using namespace whorl;

namespace plates {

namespace {

/// Uneven particles 2 mm apart in a plane of 0.24 m x 0.12 m, which turn about its middle, faster the nearer they are.
Frame vortex() {
    Frame frame;
    frame.dimensions = 2;
    frame.spacing = 0.002f;
    frame.domain_max = Vec3f(0.24f, 0.12f, 0);
    frame.time = 1.25;
    RandomNumbers random(1);
    for (int j = 0; j < 60; ++j)
        for (int i = 0; i < 120; ++i) {
            const auto off = [&] { return 0.0005f * static_cast<float>(2 * random() - 1); };
            const Vec3f x = 0.002f * Vec3f(static_cast<float>(i) + 0.5f, static_cast<float>(j) + 0.5f, 0) + Vec3f(off(), off(), 0);
            const Vec3f r = x - Vec3f(0.12f, 0.06f, 0);
            const float q = r.squaredNorm() / (0.025f * 0.025f), turn = 10 * (1 - std::exp(-q)) / std::max(q, 1e-6f);
            frame.position.push_back(x);
            frame.velocity.push_back(turn * Vec3f(-r.y(), r.x(), 0));
            frame.vector["vorticity"].emplace_back(0, 0, 20 * std::exp(-q));
            frame.scalar["grain"].push_back(static_cast<float>(random()));
            // Two inks, one above the other, that have turned for 0.4 s.
            const float wound = std::sin(std::atan2(r.y(), r.x()) - 0.4f * turn);
            frame.vector["ink"].emplace_back(std::clamp(0.5f + 4 * wound, 0.0f, 1.0f), std::clamp(0.5f - 4 * wound, 0.0f, 1.0f), 0);
        }
    frame.solids = {test::solid_of(test::sphere(Vec3f(0.2f, 0.06f, 0), 0.012f, 0.001f).mesh)};
    return frame;
}

LookOptions slice_of(const std::string& field) {
    LookOptions look;
    look.style = "slice";
    look.field = field;
    look.background = "white";
    look.time_stamp = look.legend = true;
    look.title = "two inks";
    return look;
}

void compare_plate(const LookOptions& look, int width, int height, const std::string& name) {
    test::compare_with_stored(draw_slice_image(vortex(), look, look.range, {width, height}), name, "Cairo");
}

}  // namespace

TEST_CASE("two inks that a vortex winds up, on white paper", "[golden]") {
    LookOptions look = slice_of("ink");
    look.inks.of = {"#1e50a0", "#e6b400"};
    look.streaks = false;
    compare_plate(look, 320, 240, "slice_ink");
}

TEST_CASE("vorticity with streaks, a solid, a legend and the time, on black", "[golden]") {
    LookOptions look = slice_of("vorticity");
    look.colour_map = "inferno";
    look.range = {0, 20};
    look.background = "dark";
    look.title = "a vortex";
    compare_plate(look, 480, 240, "slice_vorticity");
}

TEST_CASE("vorticity in relief with iso-lines and arrows", "[golden]") {
    LookOptions look = slice_of("vorticity");
    look.colour_map = "coolwarm";
    look.range = {-20, 20};
    look.streaks = false;
    look.isolines = 15, look.arrows = 16, look.relief = 0.7f;
    compare_plate(look, 480, 320, "slice_marks");
}

}  // namespace plates
