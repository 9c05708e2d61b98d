#pragma once
/// What the particles carry, on the surface.
#include <map>
#include <string>
#include <vector>

#include "engine/io/frame.h"

namespace whorl {

/// Means of the particles' values about each vertex, weights falling from 1 to 0 at `reach` [m]; 0 where none is that near.
std::vector<float> values_at(Span<const Vec3f> vertex, Span<const Vec3f> particle, Span<const float> value, float reach);
std::vector<Vec3f> values_at(Span<const Vec3f> vertex, Span<const Vec3f> particle, Span<const Vec3f> value, float reach);

/// What the fluid carries at points on or near its surface, by the fields' names, a value a point.
struct VertexFields {
    std::map<std::string, std::vector<float>> scalar;  ///< viscosity [Pa s], age [s], as far as the frame has them
    std::map<std::string, std::vector<Vec3f>> vector;  ///< velocity [m/s], ink
};

/// The linear field that fits the particles within `reach` [m] best, by weighted least squares, taken at the point: linear fields come out
/// as they are, at a surface too, where means lag behind by what the field changes from the surface to the particles. Where the particles
/// stand in a line or a sheet it is linear along it alone. Amounts that cannot be negative stay positive, inks stay within 0 and 1. 0 where
/// no particle is that near. The same bits for any number of threads.
VertexFields carried_at(Span<const Vec3f> point, const Frame& frame, float reach);

}  // namespace whorl
