#pragma once
/// Images in memory and on disk. Only image.cpp includes stb.
#include <cstdint>
#include <filesystem>
#include <vector>

#include "engine/core/colour.h"
#include "engine/core/grid_index.h"

namespace whorl {

/// 8-bit sRGB, rows from the top, three bytes per pixel.
struct Image {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgb;
    std::vector<std::uint8_t> alpha = {};  ///< one byte per pixel, straight: `rgb` is not multiplied by it; empty: opaque
    std::uint8_t* pixel(int x, int y) { return &rgb[3 * grid_index(x, y, width)]; }
    const std::uint8_t* pixel(int x, int y) const { return &rgb[3 * grid_index(x, y, width)]; }
};

/// Red, green, blue and alpha, four bytes per pixel.
std::vector<std::uint8_t> with_alpha(const Image& image);
/// The image over a middle grey, for formats without alpha.
Image over_grey(Image image);
/// An image of one uniform grey.
Image plain_image(int width, int height, std::uint8_t grey);
/// Writes under a temporary name and renames the complete file. @throws EnvironmentError (disk full, no such folder)
void write_png(const std::filesystem::path& file, const Image& image);
/// @throws InputError if the file is missing or is not a PNG file
Image read_png(const std::filesystem::path& file);
/// A picture on a solid, without its alpha. @throws InputError if the file is missing, is not a PNG or JPEG file, or is larger than 8192 x
/// 8192
Image read_texture(const std::filesystem::path& file);
std::vector<std::uint8_t> encode_png(const Image& image);
/// JPEG has no alpha: a transparent image is laid over grey.
std::vector<std::uint8_t> encode_jpeg(const Image& image, int quality);

/// sRGB value of linear light (IEC 61966-2-1), both 0 to 1. The inverse function is linear_of().
float srgb_of(float light);
/// Linear light of an sRGB byte, 0 to 1.
float linear_light(std::uint8_t srgb);
/// sRGB byte nearest to a linear light, which is clamped to 0 .. 1.
std::uint8_t srgb_byte(float light);

/// Mean, 99th percentile and maximum of the perceptual difference (CIE76 delta E in L*a*b*). A 3x3 blur comes first, so that one-pixel
/// shifts of an edge count little. All are infinite if the sizes differ.
struct PictureDifference {
    double mean = 0, p99 = 0, max = 0;
};
PictureDifference difference(const Image& a, const Image& b);

/// The image reduced in size by averaging linear light.
Image downscaled(const Image& image, int width, int height);
/// Images in order, in rows of `columns`, each at most cell_width wide, with small gaps. Transparent images are laid over grey.
Image contact_sheet(const std::vector<Image>& images, int columns, int cell_width);
/// Two images of equal width, one above the other.
Image one_above_other(const Image& above, const Image& below);
/// Images of equal size in a grid, row by row, centred in an image of width x height. Gaps and margins have the colour of the first image's
/// top left corner.
Image side_by_side(const std::vector<Image>& images, int columns, int gap, int width, int height);

}  // namespace whorl
