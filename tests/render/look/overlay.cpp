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

TEST_CASE("ticks are round numbers within the range, in the same format", "[render]") {
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
    CHECK(ticks_of(2.5, 0, 7).label == speed.label);  // a reversed map
    for (double high : {1.0, 1.2, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 77.7, 1e-7, 3e9}) {
        const Ticks t = ticks_of(0, high, 7);
        INFO("0 to " << high);
        CHECK(t.label.size() >= 3);
        CHECK(t.label.size() <= 7);
    }
}

namespace {

/// Pixels that the text changes in a grey image.
std::vector<std::array<int, 2>> changed_pixels(const LookOptions& look, double time, int width, int height, float aspect) {
    Image image = plain_image(width, height, 160);
    const std::array<float, 2> range{0, 2};
    draw_words(image, layout_of(width, height, aspect, look, range), look, range, time);
    std::vector<std::array<int, 2>> changed;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            if (image.pixel(x, y)[0] != 160) changed.push_back({x, y});
    return changed;
}

LookOptions wordy() {
    LookOptions look;
    look.style = "slice";
    look.field = "vorticity";
    look.title = "no spin";
    look.legend = look.time_stamp = true;
    return look;
}

}  // namespace

TEST_CASE("a legend shows the map from end to end with the field's name and unit", "[render]") {
    LookOptions look = wordy();
    for (const float aspect : {0.5f, 4.0f}) {
        Image image = plain_image(640, 360, 160);
        draw_words(image, layout_of(640, 360, aspect, look, {0, 2}), look, {0, 2}, 1);
        for (const float t : {0.0f, 0.25f, 0.5f, 0.75f, 1.0f}) CHECK(holds(image, map_colour("viridis", t)));
    }
    look.field = "speed";
    CHECK(field_title(look) == "speed [m/s]");
    look.field = "spin";
    look.colour_map = "coolwarm";
    CHECK(field_title(look) == "spin z [1/s]");
}

TEST_CASE("no text overlaps the flow or is cut off, for any aspect of flow and image", "[render]") {
    const LookOptions look = wordy();
    const int sizes[][2] = {{640, 360}, {640, 178}, {318, 360}, {1280, 720}, {1920, 1080}, {420, 420}};
    for (const auto& [width, height] : sizes)
        for (const float aspect : {0.4f, 1.0f, 1.78f, 3.1f, 6.0f}) {
            const PictureBox flow = layout_of(width, height, aspect, look, {0, 2}).flow;
            INFO(width << " x " << height << ", flow " << aspect << ": " << flow.width << " x " << flow.height);
            // The flow keeps its aspect ratio and uses the part of the image that the text leaves free.
            CHECK(std::abs(static_cast<float>(flow.width) - aspect * static_cast<float>(flow.height)) <= 0.51f * std::max(1.0f, aspect));
            CHECK((flow.width > 0.6 * width || flow.height > 0.6 * height));
            for (const auto& [x, y] : changed_pixels(look, 12.5, width, height, aspect)) {
                const bool on_flow = x >= flow.x && x < flow.x + flow.width && y >= flow.y && y < flow.y + flow.height;
                REQUIRE_FALSE(on_flow);
                REQUIRE((x > 0 && y > 0 && x + 1 < width && y + 1 < height));
            }
        }
}

TEST_CASE("without text the flow uses the whole image", "[render]") {
    LookOptions look;
    look.style = "slice";
    const PictureBox wide = layout_of(640, 360, 16.0f / 9, look, {0, 1}).flow;
    CHECK((wide.x == 0 && wide.y == 0 && wide.width == 640 && wide.height == 360));
    CHECK(layout_of(640, 360, 1, look, {0, 1}).flow.height == 360);
}

TEST_CASE("from frame to frame only the digits of the time change", "[render]") {
    LookOptions look = wordy();
    look.legend = false;
    look.title.clear();
    const auto first = changed_pixels(look, 1.25, 640, 360, 1.5f), second = changed_pixels(look, 1.5, 640, 360, 1.5f);
    CHECK(first != second);
    CHECK_FALSE(first.empty());
}
