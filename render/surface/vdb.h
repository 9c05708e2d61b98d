#pragma once
/// OpenVDB files of a frame.
#include <filesystem>

#include "render/surface/surface.h"

namespace whorl {

/// Writes a .vdb file that other programs open: a level set "surface" and a fog volume "density", plus the named vector field "velocity".
void write_vdb(const std::filesystem::path& file, const Frame& frame, const SurfaceOptions& options);

}  // namespace whorl
