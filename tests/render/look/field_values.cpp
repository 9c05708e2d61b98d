#include "render/look/field_values.h"

#include <catch2/catch.hpp>

using namespace whorl;

TEST_CASE("a descending range reverses the colours, not the strength", "[render]") {
    Frame frame;
    frame.position.assign(2, Vec3f::Zero());
    frame.velocity = {Vec3f(0.25f, 0, 0), Vec3f(1, 0, 0)};
    LookOptions look;
    look.field = "speed", look.colour_map = "viridis";
    const FieldColours up = field_colours(frame, look, {0, 1}), down = field_colours(frame, look, {1, 0});
    CHECK(up.strength == std::vector<float>{0.25f, 1});
    CHECK(down.strength == up.strength);
    CHECK((down.colour[1] - field_colours(frame, look, {1, 2}).colour[1]).norm() < 1e-6f);
}

TEST_CASE("images of inks show the ink markers, or the particles if there are none", "[render]") {
    Frame frame;
    frame.spacing = 0.2f;
    frame.position.assign(2, Vec3f::Zero());
    CHECK(inked_points(frame).position == frame.position);
    frame.ink_markers.spacing = 0.1f;
    frame.ink_markers.position.assign(3, Vec3f::Ones());
    frame.ink_markers.ink.assign(3, Vec3f(0, 1, 0));
    const Frame shown = inked_points(frame);
    CHECK(shown.spacing == 0.1f);
    CHECK(shown.position == frame.ink_markers.position);
    CHECK(shown.vector.at("ink") == frame.ink_markers.ink);
}
