#pragma once
/// Values of the particles at points on the surface.
#include <array>
#include <map>
#include <string>
#include <vector>

#include "engine/core/types.h"
#include "engine/io/frame.h"

namespace whorl {

/// Mean of the particles' values around each vertex. Weights fall from 1 to 0 at `reach` [m]; 0 if no particle is within reach.
std::vector<float> values_at(Span<const Vec3f> vertex, Span<const Vec3f> particle, Span<const float> value, float reach);
std::vector<Vec3f> values_at(Span<const Vec3f> vertex, Span<const Vec3f> particle, Span<const Vec3f> value, float reach);

/// Values of the fluid at points on or near its surface, by field name, one per point.
struct VertexFields {
    std::map<std::string, std::vector<float>> scalar;  ///< viscosity [Pa s], age [s], those that the frame has
    std::map<std::string, std::vector<Vec3f>> vector;  ///< velocity [m/s], ink
};

/// Value at each point of the linear field that fits the particles within `reach` [m] best, by weighted least squares. It is exact for
/// linear fields between particles. It is clamped to the values of those particles (each component, and the length of a vector). For
/// particles in a line or a sheet the field is linear along these directions only; for particles at one position it is the mean. 0 if no
/// particle is within reach. Bit-identical for any number of threads.
VertexFields carried_at(Span<const Vec3f> point, const Frame& frame, float reach);

/// At a vertex: distance from the nearest edge of its large plate and of its small plate [spacings], the large plate's random number,
/// and a number that varies from particle to particle (both 0 to 1).
using CrustPlace = std::array<float, 4>;

/// Place of each vertex in the plates of the crust. Some particles, chosen by their grain, are the middles of plates. A vertex belongs to
/// the plate of the nearest middle (Voronoi cells, about seven spacings wide for large plates and three for small ones). The same particles
/// are chosen in every frame, so a plate moves and deforms with the fluid.
/// @param vertex, particle positions [m] @param grain random number per particle, 0 to 1 @param spacing m
std::vector<CrustPlace> crust_places(Span<const Vec3f> vertex, Span<const Vec3f> particle, Span<const float> grain, float spacing);

}  // namespace whorl
