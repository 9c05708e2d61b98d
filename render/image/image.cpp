#include "render/image/image.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <span>
#include <string>

#include "engine/core/atomic_file.h"
#include "engine/core/errors.h"
#include "engine/core/parallel.h"

// stb's own deflate needs 0.2 s for an image of 1280x720. After prediction a rendered image is noise with runs of zeros. Searching only for
// runs is zlib's fastest strategy, and compresses as well as a full search at zlib's fastest level.
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
#define STBI_ONLY_JPEG
#include <stb_image.h>
#include <stb_image_write.h>

namespace whorl {
namespace {

void append(void* bytes, void* data, int size) {
    auto* to = static_cast<std::vector<std::uint8_t>*>(bytes);
    const auto* from = static_cast<const std::uint8_t*>(data);
    to->insert(to->end(), from, from + size);
}

// The filter "Up" predicts soft gradients nearly as well as the best filter of each row. stb finds the best one by trying all five, which
// takes a fifth more time.
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
    write_atomically(file, std::as_bytes(std::span(bytes)));
}

Image read_png(const std::filesystem::path& file) {
    Image image;
    int channels = 0;
    stbi_info(file.c_str(), &image.width, &image.height, &channels);
    const bool has_alpha = channels == 2 || channels == 4;
    stbi_uc* pixels = stbi_load(file.c_str(), &image.width, &image.height, &channels, has_alpha ? 4 : 3);
    if (pixels == nullptr)
        throw InputError({file.string()}, std::string("cannot read the image: ") + stbi_failure_reason(), "", "a PNG file");
    const std::size_t count = grid_count(image.width, image.height);
    if (!has_alpha) image.rgb.assign(pixels, pixels + 3 * count);
    for (std::size_t i = 0; has_alpha && i < count; ++i) {
        image.rgb.insert(image.rgb.end(), pixels + 4 * i, pixels + 4 * i + 3);
        image.alpha.push_back(pixels[4 * i + 3]);
    }
    stbi_image_free(pixels);
    return image;
}

Image read_texture(const std::filesystem::path& file) {
    constexpr int most = 8192;
    Image image;
    int channels = 0;
    const bool fits = stbi_info(file.c_str(), &image.width, &image.height, &channels) == 0 || std::max(image.width, image.height) <= most;
    stbi_uc* pixels = fits ? stbi_load(file.c_str(), &image.width, &image.height, &channels, 3) : nullptr;
    if (pixels == nullptr)
        throw InputError({file.string()}, std::string("cannot read the picture: ") + (fits ? stbi_failure_reason() : "it is too large"), "",
                         "a PNG or JPEG file, at most 8192 x 8192 pixels");
    image.rgb.assign(pixels, pixels + 3 * grid_count(image.width, image.height));
    stbi_image_free(pixels);
    return image;
}

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

namespace {

// Mean linear light of the 3x3 pixels about (x, y); pixels outside repeat the edge.
Vec3f blurred(const Image& image, int x, int y) {
    Vec3f sum = Vec3f::Zero();
    for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
            const std::uint8_t* p = image.pixel(std::clamp(x + dx, 0, image.width - 1), std::clamp(y + dy, 0, image.height - 1));
            sum += Vec3f(linear_light(p[0]), linear_light(p[1]), linear_light(p[2]));
        }
    return sum / 9;
}

// CIE 1976 L*a*b* of linear sRGB under D65.
Vec3f lab(const Vec3f& rgb) {
    static const Mat3f to_xyz =
        (Mat3f() << 0.4124564f, 0.3575761f, 0.1804375f, 0.2126729f, 0.7151522f, 0.0721750f, 0.0193339f, 0.1191920f, 0.9503041f).finished();
    static const Vec3f white = to_xyz * Vec3f::Ones();
    const auto f = [](float t) { return t > 216.0f / 24389 ? std::cbrt(t) : (24389.0f / 27 * t + 16) / 116; };
    const Vec3f xyz = to_xyz * rgb;
    const Vec3f g(f(xyz.x() / white.x()), f(xyz.y() / white.y()), f(xyz.z() / white.z()));
    return {116 * g.y() - 16, 500 * (g.x() - g.y()), 200 * (g.y() - g.z())};
}

}  // namespace

PictureDifference difference(const Image& a, const Image& b) {
    if (a.width != b.width || a.height != b.height) {
        const double infinite = std::numeric_limits<double>::infinity();
        return {infinite, infinite, infinite};
    }
    const Index pixels = a.width * a.height;
    if (pixels == 0) return {};
    std::vector<float> delta(pixels);
    parallel_for(pixels, [&](Index i) {
        const int x = i % a.width, y = i / a.width;
        delta[i] = (lab(blurred(a, x, y)) - lab(blurred(b, x, y))).norm();
    });
    PictureDifference result;
    result.mean = parallel_sum(pixels, [&](Index i) { return delta[i]; }) / pixels;
    std::sort(delta.begin(), delta.end());
    result.p99 = delta[0.99 * (pixels - 1)];
    result.max = delta.back();
    return result;
}

}  // namespace whorl
