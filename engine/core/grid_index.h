#pragma once
/// Array index of an entry of an image or a volume. The first coordinate varies fastest.
#include <cstddef>

namespace whorl {

constexpr std::size_t grid_index(int i, int j, int nx) { return static_cast<std::size_t>(j) * nx + i; }
constexpr std::size_t grid_index(int i, int j, int k, int nx, int ny) { return (static_cast<std::size_t>(k) * ny + j) * nx + i; }
constexpr std::size_t grid_count(int nx, int ny, int nz = 1) { return static_cast<std::size_t>(nx) * ny * nz; }

}  // namespace whorl
