#include <catch2/catch.hpp>
#include <cstring>
#include <fstream>

#include "engine/core/errors.h"
#include "engine/core/random.h"
#include "engine/io/csv.h"
#include "render/image/exr.h"
#include "render/image/text.h"
#include "render/video/process.h"
#include "tests/support/scratch.h"

using namespace whorl;

namespace layers_test {

namespace {

/// A number that a half float represents exactly: 11 bits, 2^-8 to 2^8.
float some_half(RandomNumbers& random) {
    return std::ldexp(1 + static_cast<float>(static_cast<int>(1024 * random())) / 1024, static_cast<int>(16 * random()) - 8);
}

/// Layers of odd sizes, so that rows are not aligned.
PictureLayers noise() {
    RandomNumbers random(7);
    PictureLayers layers{37, 23};
    const std::size_t pixels = grid_count(layers.width, layers.height);
    for (auto [values, channels] : {std::pair{&layers.light, 4}, {&layers.shadow, 3}, {&layers.normal, 3}, {&layers.motion, 2}})
        for (std::size_t i = 0; i < channels * pixels; ++i) values->push_back((random() < 0.5 ? -1 : 1) * some_half(random));
    for (std::size_t i = 0; i < pixels; ++i) {
        layers.depth.push_back(i % 5 == 0 ? nothing_there : static_cast<float>(random()));
        layers.id.push_back(static_cast<std::uint32_t>(i));
    }
    return layers;
}

/// One pixel of that light, over that shadow where there is one.
Image pixel(const std::vector<float>& light, const std::vector<float>& shadow) { return shown(PictureLayers{1, 1, light, shadow}); }

}  // namespace

TEST_CASE("layers read back bit-identically from EXR, and another program reads equal halves", "[image][exr]") {
    const test::ScratchFolder folder;
    const PictureLayers layers = noise();
    write_exr(folder / "a.exr", layers, {24, 1.5});
    const PictureLayers back = read_exr(folder / "a.exr");
    CHECK((back.width == 37 && back.height == 23));
    CHECK((back.light == layers.light && back.shadow == layers.shadow && back.normal == layers.normal && back.motion == layers.motion));
    CHECK((back.depth == layers.depth && back.id == layers.id));

    ChildProcess decode({"ffmpeg", "-nostdin", "-loglevel", "error", "-i", (folder / "a.exr").string(), "-f", "rawvideo", "-pix_fmt",
                         "gbrapf32le", (folder / "raw").string()});
    const int status = decode.wait();
    INFO(decode.output());
    REQUIRE(status == 0);
    const std::string raw = read_whole(folder / "raw");
    const std::size_t pixels = layers.id.size();
    REQUIRE(raw.size() == 16 * pixels);
    std::vector<float> planes(4 * pixels);
    std::memcpy(planes.data(), raw.data(), raw.size());
    const int plane_of[] = {2, 0, 1, 3};  // ffmpeg's planes are green, blue, red, alpha
    std::size_t same = 0;
    for (std::size_t i = 0; i < pixels; ++i)
        for (std::size_t c = 0; c < 4; ++c)
            same += planes[static_cast<std::size_t>(plane_of[c]) * pixels + i] == layers.light[4 * i + c] ? 1 : 0;
    CHECK(same == 4 * pixels);
}

TEST_CASE("an EXR file has only the requested layers, and a broken one is an input error", "[image][exr]") {
    const test::ScratchFolder folder;
    PictureLayers plain = noise();
    plain.shadow.clear(), plain.depth.clear(), plain.normal.clear(), plain.motion.clear(), plain.id.clear();
    write_exr(folder / "a.exr", plain, {});
    const PictureLayers back = read_exr(folder / "a.exr");
    CHECK(back.light == plain.light);
    CHECK((back.shadow.empty() && back.depth.empty() && back.id.empty()));
    const std::string whole = read_whole(folder / "a.exr");
    std::ofstream(folder / "cut.exr", std::ios::binary) << whole.substr(0, whole.size() / 2);
    std::ofstream(folder / "none.exr") << "no picture";
    for (const char* name : {"cut.exr", "none.exr", "missing.exr"}) CHECK_THROWS_AS(read_exr(folder / name), InputError);
    CHECK_THROWS_AS(write_exr("/dev/full/a.exr", plain, {}), EnvironmentError);
}

TEST_CASE("layers for screens have straight alpha with the shadow as black", "[image][exr]") {
    CHECK(pixel({0.5f, 0.5f, 0.5f, 1}, {}).alpha.empty());
    // Half covered: the colour of full cover with alpha 1/2.
    const Image whole = pixel({0.4f, 0.2f, 0.1f, 1}, {1, 1, 1}), half = pixel({0.2f, 0.1f, 0.05f, 0.5f}, {1, 1, 1});
    CHECK(whole.alpha[0] == 255);
    CHECK(half.alpha[0] == 128);
    CHECK(half.rgb == whole.rgb);
    // Empty pixels: the remaining light, 0.735 on a screen for half of it. Added light cannot be represented.
    const Image shadow = pixel({0, 0, 0, 0}, {0.5f, 0.5f, 0.5f}), gathered = pixel({0, 0, 0, 0}, {1.5f, 1.5f, 1.5f});
    CHECK(shadow.alpha[0] == 255 - 188);
    CHECK(shadow.rgb == std::vector<std::uint8_t>{0, 0, 0});
    CHECK(gathered.alpha[0] == 0);
}

TEST_CASE("a PNG keeps its alpha, and formats without alpha get the image over grey", "[image][exr]") {
    const test::ScratchFolder folder;
    Image image{2, 1, {200, 100, 0, 10, 20, 30}, {255, 0}};
    write_png(folder / "a.png", image);
    const Image back = read_png(folder / "a.png");
    CHECK(back.rgb == image.rgb);
    CHECK(back.alpha == image.alpha);
    CHECK(over_grey(image).rgb == std::vector<std::uint8_t>{200, 100, 0, 118, 118, 118});
    CHECK(over_grey(image).alpha.empty());
}

TEST_CASE("text on a transparent image is opaque and keeps its colour", "[image][exr]") {
    Image image = plain_image(60, 30, 0);
    image.alpha.assign(1800, 0);
    TextStyle white;
    white.height = 20, white.colour = Vec3f::Ones(), white.halo_strength = 0;
    draw_text(image, 5, 25, "I", white);
    bool any = false;
    for (std::size_t i = 0; i < 1800; ++i) {
        any = any || image.alpha[i] == 255;
        if (image.alpha[i] > 0) REQUIRE(image.rgb[3 * i] == 255);
    }
    CHECK(any);
    CHECK(image.alpha[0] == 0);
}

}  // namespace layers_test
