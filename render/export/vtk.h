#pragma once
/// Files of the VTK library, for ParaView: arrays lie in them as they do in memory, appended, and are named with their units.
#include <array>
#include <filesystem>
#include <utility>

#include "render/export/attributes.h"
#include "render/flow/flow_grid.h"

namespace whorl {

/// A .vtp file: points, each a cell of its own, or a mesh. Whole or not at all. @throws EnvironmentError
/// @param time s @param triangles null: points
void write_vtp(const std::filesystem::path& file, double time, const Attributes& points,
               const std::vector<std::array<std::uint32_t, 3>>* triangles = nullptr);

/// A .vti file of the flow on a grid: means of the particles' attributes about each node (flow_grid.h), and "cover", 0 where no fluid is
/// near to 1 within it. A flow of two dimensions is one layer of nodes in the plane z = 0. Periodic axes end on the node that they began
/// with. @throws EnvironmentError
/// @param particles attributes of the frame's particles; whole numbers and the radius are left out
void write_vti(const std::filesystem::path& file, const Frame& frame, const Attributes& particles);

/// One file of a .pvd collection.
struct TimedFile {
    double time = 0;   ///< s
    std::string part;  ///< "points"; files of the same part follow each other in time
    std::string file;  ///< beside the .pvd
};
void write_pvd(const std::filesystem::path& file, const std::vector<TimedFile>& files);

}  // namespace whorl
