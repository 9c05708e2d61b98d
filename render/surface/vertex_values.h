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
    std::map<std::string, std::vector<float>> scalar;  ///< viscosity [Pa s], age [s], temperature [K], those that the frame has
    std::map<std::string, std::vector<Vec3f>> vector;  ///< velocity [m/s], ink
};

/// Value at each point of the linear field that fits the particles within `reach` [m] best, by weighted least squares. It is exact for
/// linear fields between particles. It is clamped to the values of those particles (each component, and the length of a vector). For
/// particles in a line or a sheet the field is linear along these directions only; for particles at one position it is the mean. 0 if no
/// particle is within reach. Bit-identical for any number of threads.
VertexFields carried_at(Span<const Vec3f> point, const Frame& frame, float reach);

/// A plate of the crust on cooling fluid. It moves with the particle at its middle.
struct CrustPlate {
    Vec3f middle;    ///< m
    float radius;    ///< m; negative if a larger plate is close
    Vec3f velocity;  ///< m/s
    float number;    ///< random, 0 to 1
};

/// Plates of the crust. A point x belongs to the plate with the smallest |x - middle| - radius, so plates are of unequal size, and one that
/// is inside a larger one appears when the two move apart. The same particles, chosen by their grain, are the middles in every frame.
struct Crust {
    std::vector<CrustPlate> plate;
    std::vector<std::array<float, 4>> nearest;  ///< per vertex: the four nearest plates, in ascending order of that distance; -1: none
};

/// @param vertex m @param grain random number of each particle, 0 to 1
Crust crust_of(Span<const Vec3f> vertex, const Frame& frame, Span<const float> grain);

}  // namespace whorl
