#pragma once
/// OpenEXR files. Only exr.cpp includes OpenEXR.
#include "render/image/image.h"

namespace whorl {

/// Depth of empty pixels [m].
inline constexpr float nothing_there = 1e10f;

/// Layers of an image, rows from the top. A layer that was not requested is empty.
struct PictureLayers {
    int width = 0, height = 0;
    std::vector<float> light = {};       ///< red, green, blue, alpha per pixel: linear, Rec. 709, multiplied by alpha, half precision
    std::vector<float> shadow = {};      ///< red, green, blue: factors of the light on the ground; only for a transparent image
    std::vector<float> depth = {};       ///< m along the view axis; nothing_there in empty pixels
    std::vector<float> normal = {};      ///< x, y, z in the world, towards the viewer; 0 in empty pixels
    std::vector<float> motion = {};      ///< pixels to the right and up, from this image to the next
    std::vector<std::uint32_t> id = {};  ///< 0 nothing or the ground, 1 the fluid, 2 the first solid, ...
};

/// Image for screens: tone-mapped, sRGB. A transparent image has straight alpha, which includes the shadow as black. It is to be blended
/// with sRGB values, as video editors do.
Image shown(const PictureLayers& layers);

/// Metadata of the file.
struct ExrNotes {
    double fps = 24;
    double time = 0;  ///< s, simulated
};

/// Writes the channels of the layers that are not empty: R G B A (half), Z (float), N.X N.Y N.Z (half), forward.u forward.v (half),
/// id.X (unsigned), shadow.R shadow.G shadow.B (half). Compression is lossless. The file is written completely or not at all.
/// @throws EnvironmentError (disk full, no such folder)
void write_exr(const std::filesystem::path& file, const PictureLayers& layers, const ExrNotes& notes);
/// Reads the layers of a file, with the channel names of write_exr().
/// @throws InputError if the file is missing or damaged, has no R G B, or has more than 16384 pixels in a row or column
PictureLayers read_exr(const std::filesystem::path& file);

}  // namespace whorl
