#pragma once
/// Pictures in memory and on disk. The only place that includes stb (image.cpp).
#include <cstdint>
#include <filesystem>
#include <vector>

#include "engine/core/grid_index.h"

namespace whorl {

/// 8-bit sRGB, rows from the top, three bytes a pixel.
struct Image {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgb;
    std::vector<std::uint8_t> alpha = {};  ///< one byte a pixel, straight: `rgb` is as if nothing shone through; empty: opaque
    std::uint8_t* pixel(int x, int y) { return &rgb[3 * grid_index(x, y, width)]; }
    const std::uint8_t* pixel(int x, int y) const { return &rgb[3 * grid_index(x, y, width)]; }
};

/// Four bytes a pixel, as other programs take them.
std::vector<std::uint8_t> with_alpha(const Image& image);
/// The image over a middle grey, for formats without alpha.
Image over_grey(Image image);
/// An image of a single grey.
Image plain_image(int width, int height, std::uint8_t grey);
/// Writes under a temporary name and renames when whole. @throws EnvironmentError (disk full, no such folder)
void write_png(const std::filesystem::path& file, const Image& image);
/// @throws InputError if the file is missing or no picture
Image read_png(const std::filesystem::path& file);
std::vector<std::uint8_t> encode_png(const Image& image);
/// JPEG has no alpha: a transparent picture is laid over grey.
std::vector<std::uint8_t> encode_jpeg(const Image& image, int quality);

/// The light of an sRGB value (IEC 61966-2-1), and the other way round; both 0 to 1.
float linear_of(float srgb);
float srgb_of(float light);
/// The light of an sRGB byte, 0 to 1.
float linear_light(std::uint8_t srgb);
/// The nearest sRGB byte of a light, clamped.
std::uint8_t srgb_byte(float light);

/// Mean and largest perceptual difference (CIE76 delta E in L*a*b*, after a 3x3 blur so that one-pixel shifts of an edge count little);
/// infinite if the sizes differ.
struct PictureDifference {
    double mean = 0, p99 = 0, max = 0;
};
PictureDifference difference(const Image& a, const Image& b);

/// The picture made smaller by averaging in linear light.
Image downscaled(const Image& image, int width, int height);
/// Pictures side by side in rows of `columns`, each at most cell_width wide, in order, with small gaps; opaque, transparent ones over grey.
Image contact_sheet(const std::vector<Image>& images, int columns, int cell_width);
/// Two pictures of one width.
Image one_above_other(const Image& above, const Image& below);
/// Pictures of one size in a grid, row by row, in the middle of a picture of width x height. Gaps and margins have the colour of the first
/// picture's top left corner.
Image side_by_side(const std::vector<Image>& images, int columns, int gap, int width, int height);

}  // namespace whorl
