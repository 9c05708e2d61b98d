#include "render/image/text.h"

#include <catch2/catch.hpp>
#include <map>

using namespace whorl;

namespace {

Image letter(char c, float height) {
    Image image = plain_image(3 * static_cast<int>(height), 3 * static_cast<int>(height), 255);
    draw_text(image, height, 2 * height, std::string(1, c), {height, Vec3f::Zero(), Vec3f::Ones(), 0});
    return image;
}

std::string pixels(const Image& image) { return {image.rgb.begin(), image.rgb.end()}; }

}  // namespace

TEST_CASE("every printable character has a distinct shape, also at the size of a legend", "[render]") {
    std::map<std::string, char> known;  // pixels as characters
    for (char c = ' '; c <= '~'; ++c) {
        if (c == '^') continue;  // lifts an exponent
        const Image image = letter(c, 12);
        const auto [place, is_new] = known.try_emplace(pixels(image), c);
        INFO(c << " looks like " << place->second);
        CHECK(is_new);
        // No letter may be a blot: it covers at most a quarter of the field of 36 x 36.
        int ink = 0;
        for (std::size_t n = 0; n < image.rgb.size(); n += 3) ink += image.rgb[n] < 128 ? 1 : 0;
        if (c != ' ') CHECK(ink >= 2);
        CHECK(ink < 36 * 36 / 4);
    }
    CHECK(known.count(pixels(letter('\x01', 12))) == 0);  // the box for a character that is missing in the font
}

TEST_CASE("text is as wide as predicted, scales with its height, and raises exponents", "[render]") {
    CHECK(text_width("m/s", 20) == Approx(2 * text_width("m/s", 10)));
    CHECK(text_width("kg/m^3", 10) < text_width("kg/m3", 10));
    Image image = plain_image(200, 60, 255);
    draw_text(image, 10, 40, "speed [m/s]", {12, Vec3f::Zero(), Vec3f::Ones(), 0});
    const auto end = static_cast<int>(10 + text_width("speed [m/s]", 12));
    int last = 0;
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x)
            if (image.pixel(x, y)[0] < 200) last = std::max(last, x);
    CHECK(std::abs(last - end) <= 2);
}

TEST_CASE("a halo makes dark text readable on black", "[render]") {
    Image image{80, 40, std::vector<std::uint8_t>(3 * 80 * 40, 0)};
    draw_text(image, 10, 30, "t = 1", {14, Vec3f::Zero(), Vec3f::Ones(), 0.6f});
    int light = 0;
    for (const std::uint8_t c : image.rgb) light = std::max(light, int(c));
    CHECK(light > 150);
}

TEST_CASE("text that extends beyond the image is cut, not wrapped", "[render]") {
    Image image = plain_image(20, 20, 255);
    draw_text(image, 10, 15, "beyond", {14, Vec3f::Zero(), Vec3f::Ones(), 0.6f});
    draw_text(image, -100, -100, "far out", {14, Vec3f::Zero(), Vec3f::Ones(), 0.6f});
    CHECK(image.rgb.size() == 1200);
}
