#include "render/image/image.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <span>
#include <string>

#include "engine/core/errors.h"
#include "engine/core/whole_file.h"

// stb's own deflate takes 0.2 s for a frame of 1280x720. After prediction a rendered picture is noise with runs of zeros: looking for runs
// alone is the quickest that zlib can, and packs as well as a full search at its fastest level.
static unsigned char* zlib_compress(unsigned char* data, int length, int* compressed_length, int level) {
    z_stream stream{};
    if (deflateInit2(&stream, level, Z_DEFLATED, 15, 9, Z_RLE) != Z_OK) return nullptr;
    const uLong bound = deflateBound(&stream, static_cast<uLong>(length));
    auto* compressed = static_cast<unsigned char*>(std::malloc(bound));
    stream.next_in = data;
    stream.avail_in = static_cast<uInt>(length);
    stream.next_out = compressed;
    stream.avail_out = static_cast<uInt>(bound);
    if (compressed != nullptr) deflate(&stream, Z_FINISH);
    *compressed_length = static_cast<int>(stream.total_out);
    deflateEnd(&stream);
    return compressed;
}

#define STBIW_ZLIB_COMPRESS zlib_compress
#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_IMPLEMENTATION
#define STBI_ONLY_PNG
#include <stb_image.h>
#include <stb_image_write.h>

namespace whorl {
namespace {

void append(void* bytes, void* data, int size) {
    auto* to = static_cast<std::vector<std::uint8_t>*>(bytes);
    const auto* from = static_cast<const std::uint8_t*>(data);
    to->insert(to->end(), from, from + size);
}

// "Up" predicts soft gradients nearly as well as the best filter of each row, which stb finds by trying all five (and a fifth more time).
const bool configured = [] {
    stbi_write_png_compression_level = 1;
    stbi_write_force_png_filter = 2;
    return true;
}();

}  // namespace

Image plain_image(int width, int height, std::uint8_t grey) {
    return {width, height, std::vector<std::uint8_t>(3 * grid_count(width, height), grey)};
}

std::vector<std::uint8_t> with_alpha(const Image& image) {
    std::vector<std::uint8_t> rgba;
    rgba.reserve(4 * image.rgb.size() / 3);
    for (std::size_t i = 0; i < image.rgb.size() / 3; ++i) {
        rgba.insert(rgba.end(), &image.rgb[3 * i], &image.rgb[3 * i] + 3);
        rgba.push_back(image.alpha.empty() ? 255 : image.alpha[i]);
    }
    return rgba;
}

Image over_grey(Image image) {
    constexpr int grey = 118;  // 18 % of the light of white
    for (std::size_t i = 0; i < image.alpha.size(); ++i)
        for (int c = 0; c < 3; ++c) {
            std::uint8_t& value = image.rgb[3 * i + c];
            value = static_cast<std::uint8_t>((value * image.alpha[i] + grey * (255 - image.alpha[i]) + 127) / 255);
        }
    image.alpha.clear();
    return image;
}

std::vector<std::uint8_t> encode_png(const Image& image) {
    std::vector<std::uint8_t> bytes;
    if (image.alpha.empty()) {
        stbi_write_png_to_func(append, &bytes, image.width, image.height, 3, image.rgb.data(), 3 * image.width);
    } else {
        const std::vector<std::uint8_t> rgba = with_alpha(image);
        stbi_write_png_to_func(append, &bytes, image.width, image.height, 4, rgba.data(), 4 * image.width);
    }
    WHORL_ASSERT(configured && !bytes.empty(), +std::to_string(image.width) + "x" + std::to_string(image.height));
    return bytes;
}

std::vector<std::uint8_t> encode_jpeg(const Image& image, int quality) {
    std::vector<std::uint8_t> bytes;
    const std::vector<std::uint8_t> rgb = image.alpha.empty() ? image.rgb : over_grey(image).rgb;
    stbi_write_jpg_to_func(append, &bytes, image.width, image.height, 3, rgb.data(), quality);
    WHORL_ASSERT(!bytes.empty(), +std::to_string(image.width) + "x" + std::to_string(image.height));
    return bytes;
}

void write_png(const std::filesystem::path& file, const Image& image) {
    const std::vector<std::uint8_t> bytes = encode_png(image);
    write_whole(file, std::as_bytes(std::span(bytes)));
}

Image read_png(const std::filesystem::path& file) {
    Image image;
    int channels = 0;
    stbi_info(file.c_str(), &image.width, &image.height, &channels);
    const bool has_alpha = channels == 2 || channels == 4;
    stbi_uc* pixels = stbi_load(file.c_str(), &image.width, &image.height, &channels, has_alpha ? 4 : 3);
    if (pixels == nullptr)
        throw InputError({file.string()}, std::string("cannot read the picture: ") + stbi_failure_reason(), "", "a PNG file");
    const std::size_t count = grid_count(image.width, image.height);
    if (!has_alpha) image.rgb.assign(pixels, pixels + 3 * count);
    for (std::size_t i = 0; has_alpha && i < count; ++i) {
        image.rgb.insert(image.rgb.end(), pixels + 4 * i, pixels + 4 * i + 3);
        image.alpha.push_back(pixels[4 * i + 3]);
    }
    stbi_image_free(pixels);
    return image;
}

float linear_of(float srgb) { return srgb <= 0.04045f ? srgb / 12.92f : std::pow((srgb + 0.055f) / 1.055f, 2.4f); }
float srgb_of(float light) { return light <= 0.0031308f ? 12.92f * light : 1.055f * std::pow(light, 1 / 2.4f) - 0.055f; }

float linear_light(std::uint8_t srgb) {
    static const auto table = [] {
        std::array<float, 256> light{};
        for (int i = 0; i < 256; ++i) light[i] = linear_of(static_cast<float>(i) / 255);
        return light;
    }();
    return table[srgb];
}

std::uint8_t srgb_byte(float light) { return static_cast<std::uint8_t>(std::lround(255 * srgb_of(std::clamp(light, 0.0f, 1.0f)))); }

}  // namespace whorl
