#include <catch2/catch.hpp>
#include <fstream>

#include "engine/core/errors.h"
#include "render/image/image.h"
#include "tests/support/scratch.h"

using namespace whorl;

namespace {

const std::string head = "#?RADIANCE\nEXPOSURE=1\nFORMAT=32-bit_rle_rgbe\n\n";

class Pictures {
public:
    FloatImage read(const std::string& bytes) const {
        std::ofstream(file_, std::ios::binary) << bytes;
        return read_hdr(file_);
    }
    void refused(const std::string& bytes, const std::string& why) const {
        CHECK_THROWS_WITH(read(bytes), Catch::StartsWith(file_.string() + ": ") && Catch::Contains(why));
    }

private:
    test::ScratchFolder folder_;
    std::filesystem::path file_ = folder_ / "sky.hdr";
};

/// Two rows of nine pixels: reds in a run, greens one by one, blues in two runs, exponents of 1 and then 4.
std::string packed() {
    const std::string row{2,  2,  0,   9,      '\x89', '\x80', 9,      0,      16,     32,     48, 64,
                          80, 96, 112, '\x7f', '\x84', 0,      '\x85', '\x40', '\x88', '\x81', 1,  '\x83'};
    return head + "-Y 2 +X 9\n" + row + row;
}
/// The image as single pixels, in a row too short to be packed.
std::string plain() { return head + "-Y 1 +X 2\n" + std::string{'\x80', 0, 0, '\x81', '\x80', '\x7f', '\x40', '\x83'}; }

}  // namespace

TEST_CASE("a Radiance picture's rows are read packed and plain, to the bit", "[render][hdr]") {
    const Pictures pictures;
    const FloatImage image = pictures.read(packed());
    REQUIRE(image.width == 9);
    REQUIRE(image.height == 2);
    for (int y = 0; y < 2; ++y)
        for (int x = 0; x < 9; ++x) {
            const float* p = &image.rgb[3 * grid_index(x, y, 9)];
            const float unit = (x < 8 ? 2.0f : 8.0f) / 256;  // an exponent of 129 and of 131
            CHECK(p[0] == 128 * unit);
            CHECK(p[1] == (x < 8 ? static_cast<float>(16 * x) : 127.0f) * unit);
            CHECK(p[2] == (x < 4 ? 0 : 64) * unit);
        }
    const FloatImage two = pictures.read(plain());
    CHECK(two.rgb == std::vector<float>{1, 0, 0, 4, 127.0f / 32, 2});
    CHECK(pictures.read(head + "-Y 1 +X 1\n" + std::string{'\x80', 1, 1, 0}).rgb == std::vector<float>{0, 0, 0});
}

TEST_CASE("a truncated or damaged Radiance image is refused with its name and fault", "[render][hdr]") {
    const Pictures pictures;
    for (const std::string& whole : {packed(), plain()})
        for (std::size_t size = 0; size < whole.size(); ++size) CHECK_THROWS_AS(pictures.read(whole.substr(0, size)), InputError);
    pictures.refused(packed().substr(0, packed().size() - 1), "the picture ends too early: 103 bytes do not hold 9 x 2 pixels");
    pictures.refused(head + "-Y 16000 +X 7\n" + std::string(40, 1), "do not hold 7 x 16000 pixels");
    pictures.refused(head + "-Y 32767 +X 32767\n" + std::string(40, 1), "do not hold 32767 x 32767 pixels");
    pictures.refused(head.substr(0, 20), "the head of the picture is cut off");
    pictures.refused("P6\n1 1 255\nabc", "is not a Radiance image");
    pictures.refused("#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\nabcd", "not of FORMAT=32-bit_rle_rgbe");
    for (const char* size : {"-Y 0 +X 4", "-Y -3 +X 4", "+Y 3 +X 4", "-Y 40000 +X 4", "-Y 3 +X 4x", "-Y 3"})
        pictures.refused(head + size + "\nabcdabcdabcd", "the size of the picture is not written as in");
    std::string damaged = packed();
    damaged.replace(damaged.size() - 4, 1, "\x8a");  // ten exponents for nine pixels
    pictures.refused(damaged, "a row of the picture is damaged");
    damaged.replace(damaged.size() - 4, 1, std::string(1, 0));  // none
    pictures.refused(damaged, "a row of the picture is damaged");
    std::string other = packed();
    other[other.find("+X 9\n") + 8] = 8;
    pictures.refused(other, "a row of the picture has 8 pixels instead of 9");
}
