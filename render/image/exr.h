#pragma once
/// OpenEXR files. The only place that includes OpenEXR (exr.cpp).
#include "render/image/image.h"

namespace whorl {

/// Depth of empty pixels [m].
inline constexpr float nothing_there = 1e10f;

/// Rows from the top. A layer that is empty was not asked for.
struct PictureLayers {
    int width = 0, height = 0;
    std::vector<float> light = {};       ///< red, green, blue, alpha a pixel: linear, Rec. 709, multiplied by alpha; of half precision
    std::vector<float> shadow = {};      ///< red, green, blue: factors of the ground's light; only of a transparent picture
    std::vector<float> depth = {};       ///< m along the view axis; nothing_there where nothing is
    std::vector<float> normal = {};      ///< x, y, z of the world, towards the viewer; 0 where nothing is
    std::vector<float> motion = {};      ///< pixels to the right and up, from this picture to the next
    std::vector<std::uint32_t> id = {};  ///< 0 nothing or the ground, 1 the fluid, 2 the first solid, ...
};

/// The picture that screens show: tone-mapped, sRGB. A transparent one has straight alpha, which holds the shadow too, as black: it is to
/// be laid over the values of pixels, as video editors do.
Image shown(const PictureLayers& layers);

/// Metadata of the file.
struct ExrNotes {
    double fps = 24;
    double time = 0;  ///< s, simulated
};

/// Channels R G B A (half), and those of the layers that are there: Z (float), N.X N.Y N.Z (half), forward.u forward.v (half),
/// id.X (unsigned), shadow.R shadow.G shadow.B (half). Compressed without loss. Whole or not at all.
/// @throws EnvironmentError (disk full, no such folder)
void write_exr(const std::filesystem::path& file, const PictureLayers& layers, const ExrNotes& notes);
/// The layers of a file, by the names of write_exr(). @throws InputError if it is missing, broken, has no R G B, or more than 16384 pixels
/// in a row or column
PictureLayers read_exr(const std::filesystem::path& file);

}  // namespace whorl
