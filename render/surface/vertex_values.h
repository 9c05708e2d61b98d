#pragma once
/// Particle values on the surface.
#include <array>
#include <map>
#include <string>
#include <vector>

#include "engine/core/types.h"
#include "engine/io/frame.h"

namespace whorl {

/// Means of the particles' values about each vertex, weights falling from 1 to 0 at `reach` [m]; 0 if none is that near.
std::vector<float> values_at(Span<const Vec3f> vertex, Span<const Vec3f> particle, Span<const float> value, float reach);
std::vector<Vec3f> values_at(Span<const Vec3f> vertex, Span<const Vec3f> particle, Span<const Vec3f> value, float reach);

/// Values of the fluid at points on or near its surface, by field name, one per point.
struct VertexFields {
    std::map<std::string, std::vector<float>> scalar;  ///< viscosity [Pa s], age [s], as far as the frame has them
    std::map<std::string, std::vector<Vec3f>> vector;  ///< velocity [m/s], ink
};

/// The linear field that fits the particles within `reach` [m] best, by weighted least squares, taken at the point and held within the
/// values of those particles (each component, and the length of a vector): linear fields are exact between particles. Where the particles
/// lie in a line or a sheet it is linear along it alone; of particles at one place it is the mean. 0 if no particle is within reach. The
/// same bits for any number of threads.
VertexFields carried_at(Span<const Vec3f> point, const Frame& frame, float reach);

/// At a vertex: how far it is from the nearest edge of its large plate and of its small plate [spacings], a number of its large plate's own
/// and a number that varies from particle to particle (both 0 to 1).
using CrustPlace = std::array<float, 4>;

/// Some of the particles are the middles of plates, chosen by their grains; a vertex belongs to the plate whose middle is nearest (Voronoi
/// cells, about seven and three spacings wide). The same particles are chosen in every frame, so a plate moves and deforms with the fluid.
/// @param vertex, particle m @param grain of each particle, 0 to 1 @param spacing m
std::vector<CrustPlace> crust_places(Span<const Vec3f> vertex, Span<const Vec3f> particle, Span<const float> grain, float spacing);

}  // namespace whorl
