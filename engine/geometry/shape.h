#pragma once
/// Shapes for blocks of fluid and for solids, as signed distances.
#include <filesystem>
#include <memory>
#include <string>

#include "engine/core/mesh.h"

namespace whorl {

/// A shape as the scene file names it. kind: box (min, max) | sphere (position, radius) | cylinder (from, to, radius) |
/// plane (position, normal) | mesh (file, scale, position).
struct ShapeKeys {
    std::string kind = "box";
    Vec3d min = Vec3d::Zero(), max = Vec3d::Ones();
    Vec3d centre = Vec3d::Zero();  ///< sphere, plane, mesh: "position" of a block; of a solid, position is the expression that moves it
    double radius = 0;
    Vec3d from = Vec3d::Zero(), to{0, 1, 0};
    Vec3d normal{0, 1, 0};
    std::filesystem::path file;
    double scale = 1;
};

class Shape {
public:
    virtual ~Shape() = default;
    /// Signed distance [m]: negative inside.
    virtual Real distance(const Vec3& x) const = 0;
    /// Unit gradient of the distance: outward on the surface.
    virtual Vec3 normal(const Vec3& x) const;
    /// Bounds [m]; infinite along a plane.
    virtual void bounds(Vec3& min, Vec3& max) const = 0;
    virtual bool bounded() const { return true; }
    /// For drawing. @param edge wanted length of an edge [m] @param extent half-width of a plane's drawn patch [m]
    virtual TriangleMesh mesh(Real edge, Real extent) const = 0;
};

/// @throws InputError where a mesh file is missing, unreadable or not closed
std::shared_ptr<const Shape> make_shape(const ShapeKeys& keys);

}  // namespace whorl
