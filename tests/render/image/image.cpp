#include "render/image/image.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>

#include "engine/core/errors.h"
#include "tests/support/pictures.h"
#include "tests/support/scratch.h"

using namespace whorl;
using test::flat_picture;
using test::studio_picture;

TEST_CASE("a PNG reads back with equal pixels", "[image]") {
    test::ScratchFolder folder;
    const Image image = studio_picture(131, 77);  // odd sizes: rows are not aligned
    write_png(folder / "a.png", image);
    const Image back = read_png(folder / "a.png");
    REQUIRE(back.width == 131);
    REQUIRE(back.height == 77);
    REQUIRE(back.rgb == image.rgb);
}

TEST_CASE("an image that is being written is hidden and has another suffix", "[image]") {
    test::ScratchFolder folder;
    const auto names = test::names_made(folder.path(), [&] { write_png(folder / "a.png", flat_picture(16, 9, 1, 2, 3)); });
    REQUIRE(names == std::vector<std::string>{".a.png.part"});
    REQUIRE(read_png(folder / "a.png").width == 16);
}

TEST_CASE("a missing or broken image is an input error", "[image]") {
    test::ScratchFolder folder;
    REQUIRE_THROWS_AS(read_png(folder / "none.png"), InputError);
    std::ofstream(folder / "broken.png") << "no picture";
    REQUIRE_THROWS_AS(read_png(folder / "broken.png"), InputError);
    // A valid image of another format.
    std::ofstream(folder / "radiance.png") << "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\nabcd";
    REQUIRE_THROWS_AS(read_png(folder / "radiance.png"), InputError);
}

TEST_CASE("a JPEG has its start and end markers, and higher quality makes it larger", "[image]") {
    const Image image = studio_picture(160, 90);
    const auto good = encode_jpeg(image, 90), poor = encode_jpeg(image, 30);
    REQUIRE(good.size() > poor.size());
    REQUIRE((good[0] == 0xff && good[1] == 0xd8));
    REQUIRE((good[good.size() - 2] == 0xff && good.back() == 0xd9));
}

TEST_CASE("downscaling averages light, not bytes", "[image]") {
    // A fine checkerboard of black and white is half the light: sRGB 188, where averaging the bytes would give 128.
    Image checks = flat_picture(64, 64, 0, 0, 0);
    for (int y = 0; y < 64; ++y)
        for (int x = y % 2; x < 64; x += 2) std::fill_n(checks.pixel(x, y), 3, std::uint8_t{255});
    const Image small = downscaled(checks, 16, 16);
    for (std::uint8_t byte : small.rgb) REQUIRE(byte == 188);
    CHECK(srgb_byte(-0.5f) == 0);
    CHECK(srgb_byte(1.5f) == 255);
}

TEST_CASE("downscaling by any ratio keeps a flat colour", "[image]") {
    const Image flat = flat_picture(97, 53, 200, 120, 13);
    for (int width : {97, 60, 31, 1}) {
        const Image small = downscaled(flat, width, 17);
        REQUIRE(small.rgb == flat_picture(width, 17, 200, 120, 13).rgb);
    }
}

TEST_CASE("a contact sheet contains all images in order", "[image]") {
    std::vector<Image> images;
    for (int i = 0; i < 5; ++i) images.push_back(flat_picture(200, 100, static_cast<std::uint8_t>(50 * i), 0, 255));
    const Image sheet = contact_sheet(images, 3, 100);
    // Three columns of 100x50 and two rows, gaps of 2.
    REQUIRE(sheet.width == 3 * 102 + 2);
    REQUIRE(sheet.height == 2 * 52 + 2);
    for (int i = 0; i < 5; ++i) {
        const std::uint8_t* p = sheet.pixel(2 + (i % 3) * 102 + 50, 2 + (i / 3) * 52 + 25);
        REQUIRE((p[0] == 50 * i && p[2] == 255));
    }
    REQUIRE(contact_sheet({}, 3, 100).rgb.empty());
}

TEST_CASE("the perceptual difference is that of CIE L*a*b*", "[image]") {
    const Image a = studio_picture(64, 48);
    const PictureDifference same = difference(a, a);
    REQUIRE(same.max == 0);
    // White to black is 100 in L*, by definition; sRGB red to sRGB green is 170.6 (Lindbloom's calculator).
    REQUIRE(difference(flat_picture(8, 8, 255, 255, 255), flat_picture(8, 8, 0, 0, 0)).mean == Approx(100).margin(0.1));
    REQUIRE(difference(flat_picture(8, 8, 255, 0, 0), flat_picture(8, 8, 0, 255, 0)).mean == Approx(170.6).margin(0.3));
    REQUIRE(std::isinf(difference(a, studio_picture(64, 47)).mean));
}

TEST_CASE("an edge that moves by 1 pixel counts less than an edge that moves by 4", "[image]") {
    const auto edge = [](int at) {
        Image image = flat_picture(64, 64, 230, 230, 230);
        for (int y = 0; y < 64; ++y)
            for (int x = 0; x < at; ++x) std::fill_n(image.pixel(x, y), 3, std::uint8_t{30});
        return image;
    };
    const double one = difference(edge(20), edge(21)).max, four = difference(edge(20), edge(24)).max;
    REQUIRE(one < 0.7 * four);
}

TEST_CASE("the perceptual difference is equal for upright and level edges", "[image]") {
    const auto edge = [](bool upright, int at) {
        Image image = flat_picture(64, 64, 230, 230, 230);
        for (int y = 0; y < 64; ++y)
            for (int x = 0; x < 64; ++x)
                if ((upright ? x : y) < at) std::fill_n(image.pixel(x, y), 3, std::uint8_t{30});
        return image;
    };
    const PictureDifference level = difference(edge(false, 20), edge(false, 21)), upright = difference(edge(true, 20), edge(true, 21));
    CHECK(level.max == Approx(upright.max));
    CHECK(level.mean == Approx(upright.mean));
}
