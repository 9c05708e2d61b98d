#pragma once
/// OpenVDB files of a frame.
#include <array>
#include <filesystem>

#include "render/surface/surface.h"

namespace whorl {

/// Fields on the nodes of a grid; i runs fastest.
struct GridFields {
    Vec3f origin = Vec3f::Zero();  ///< m, of the first node
    Vec3f cell = Vec3f::Ones();    ///< m, from node to node
    std::array<int, 3> n{0, 0, 0};
    Span<const float> cover;     ///< 0 no fluid near: the node stays out of the file
    Span<const Vec3f> velocity;  ///< m/s
    Span<const float> density;   ///< of a cloud; empty: the file has none
};

struct VdbFile {
    int frame = 0;
    double time = 0;  ///< s
    float voxel = 0;  ///< m, of the level set
};

/// Writes the level set "surface" [m], and on the grid's nodes the vectors "velocity" [m/s] (staggered: no; halves) and, where there is
/// one, the fog volume "density". The file's metadata say frame, time, voxel sizes and units. Compressed; whole or not at all.
/// @param surface its distance volume is used where it is there and not coarser than the voxel, else one is made
/// @throws EnvironmentError
void write_vdb(const std::filesystem::path& file, const VdbFile& about, const Surface& surface, const GridFields& grid);

}  // namespace whorl
