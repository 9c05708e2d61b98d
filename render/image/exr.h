#pragma once
/// OpenEXR files. The only place that includes OpenEXR (exr.cpp).
#include "render/image/layers.h"

namespace whorl {

/// What the file tells besides its pixels.
struct ExrNotes {
    double fps = 24;
    double time = 0;  ///< s, simulated
};

/// Channels R G B A (half), and those of the layers that are there: Z (float), N.X N.Y N.Z (half), forward.u forward.v (half),
/// id.X (unsigned), shadow.R shadow.G shadow.B (half). Compressed without loss. Whole or not at all.
/// @throws EnvironmentError (disk full, no such folder)
void write_exr(const std::filesystem::path& file, const PictureLayers& layers, const ExrNotes& notes);
/// The layers of a file that write_exr() wrote. @throws InputError where it is missing, broken, or has no R G B A
PictureLayers read_exr(const std::filesystem::path& file);

}  // namespace whorl
