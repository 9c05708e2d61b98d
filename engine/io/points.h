#pragma once
/// Particles for other programs: binary PLY.
#include <filesystem>

#include "engine/io/frame.h"

namespace whorl {

/// Writes points/<number>.ply: little-endian PLY, one vertex a particle with float properties x,y,z [m], velocity_x, velocity_y, velocity_z
/// [m/s], and the frame's other fields by name (density, pressure, spin_x, spin_y, spin_z, ...). Whole or not at all. @throws
/// EnvironmentError
void write_points(const std::filesystem::path& file, const Frame& frame);

}  // namespace whorl
