#include "render/look/overlay.h"

#include <catch2/catch.hpp>

#include "render/look/colour_map.h"

using namespace whorl;

namespace {

bool holds(const Image& image, const Vec3f& colour) {
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
            const auto* p = image.pixel(x, y);
            if ((Vec3f(p[0], p[1], p[2]) - 255 * colour).cwiseAbs().maxCoeff() < 2.5f) return true;
        }
    return false;
}

}  // namespace

TEST_CASE("ticks are round numbers within the range, all written alike", "[render]") {
    const Ticks speed = ticks_of(0, 2.5, 7);
    CHECK(speed.label == std::vector<std::string>{"0.0", "0.5", "1.0", "1.5", "2.0", "2.5"});
    CHECK(speed.power == 0);
    const Ticks pressure = ticks_of(0, 250000, 7);
    CHECK(pressure.power == 5);
    CHECK(pressure.label.back() == "2.5");
    const Ticks spin = ticks_of(-30, 30, 7);
    CHECK(spin.label == std::vector<std::string>{"-30", "-20", "-10", "0", "10", "20", "30"});
    const Ticks density = ticks_of(970, 1030, 7);
    CHECK(density.label.front() == "970");
    CHECK(density.label.size() == 7);
    CHECK(ticks_of(0, 3e-4, 7).power == -4);
    for (double high : {1.0, 1.2, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 77.7, 1e-7, 3e9}) {
        const Ticks t = ticks_of(0, high, 7);
        INFO("0 to " << high);
        CHECK(t.label.size() >= 3);
        CHECK(t.label.size() <= 7);
    }
}

TEST_CASE("a legend shows the map from end to end with the field's name and unit", "[render]") {
    LookOptions look;
    look.field = "speed";
    Image image = plain_image(640, 360, 160);
    draw_legend(image, look, {0, 2});
    for (const float t : {0.0f, 0.25f, 0.5f, 0.75f, 1.0f}) CHECK(holds(image, map_colour("viridis", t)));
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width / 2; ++x) REQUIRE(image.pixel(x, y)[0] == 160);  // it stays at its edge
    CHECK(field_title(look) == "speed [m/s]");
    look.field = "spin";
    look.colour_map = "coolwarm";
    CHECK(field_title(look) == "spin z [1/s]");
}

TEST_CASE("a time stamp changes only its corner, and only in its digits from frame to frame", "[render]") {
    LookOptions look;
    Image first = plain_image(640, 360, 160), second = first;
    draw_time(first, look, 1.25);
    draw_time(second, look, 1.5);
    CHECK(first.rgb != second.rgb);
    CHECK(first.rgb != plain_image(640, 360, 160).rgb);
    for (int y = 0; y < first.height; ++y)
        for (int x = 0; x < first.width; ++x)
            if (x > 200 || y < 300) REQUIRE(first.pixel(x, y)[0] == 160);
}
