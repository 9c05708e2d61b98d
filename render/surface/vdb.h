#pragma once
/// OpenVDB files of a frame.
#include <array>
#include <filesystem>

#include "render/surface/surface.h"

namespace whorl {

/// Fields on the nodes of a grid; index i runs fastest.
struct GridFields {
    Vec3f origin = Vec3f::Zero();  ///< m, position of the first node
    Vec3f cell = Vec3f::Ones();    ///< m, distance between nodes
    std::array<int, 3> n{0, 0, 0};
    Span<const float> cover;     ///< 0 .. 1; the file omits nodes with at most 0.02
    Span<const Vec3f> velocity;  ///< m/s
    Span<const float> density;   ///< density of the cloud; empty: no such grid in the file
};

struct VdbFile {
    int frame = 0;
    double time = 0;  ///< s
    float voxel = 0;  ///< m, requested voxel of the level set
};

/// Writes the level set "surface" [m] and, on the grid's nodes, the vectors "velocity" [m/s] (not staggered, half precision) and the fog
/// volume "density" if there is one. The file's metadata state frame, time, voxel sizes and units. Compressed; written atomically.
/// @param surface its distance volume is used if it exists and is not coarser than the voxel, else a new one is computed
/// @throws EnvironmentError
void write_vdb(const std::filesystem::path& file, const VdbFile& about, const Surface& surface, const GridFields& grid);

}  // namespace whorl
