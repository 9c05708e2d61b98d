#pragma once
/// Shapes for blocks of fluid and for solids, as signed distances.
#include <filesystem>
#include <memory>
#include <string>

#include "engine/core/mesh.h"
#include "engine/geometry/domain.h"

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
    /// 2D flow: the section with the plane z = 0 counts, for all z. A box or cylinder without depth reaches through the plane.
    bool cut = false;
};

/// Region in which a shape's surface needs boundary particles, in the shape's own axes.
struct SamplingRegion {
    Real spacing = 0;      ///< m
    Domain domain;         ///< periodic axes that a box, cylinder or plane spans are filled without a seam and without ends
    Real margin = 0;       ///< m beyond the domain
    bool clipped = false;  ///< points farther out are left out
    /// Within the margin along the axes that are not periodic.
    bool contains(const Vec3d& x) const;
    /// Whether [low, high] covers a whole period of the axis, wherever it begins.
    bool spans_period(int axis, double low, double high) const;
};

struct SurfaceSample {
    Vec3d position, outward;     ///< m; unit, away from the shape's inside
    double curvature = 0;        ///< sum of the surface's principal curvatures, > 0 where it is convex [1/m]; 0 on edges and meshes
    Vec3d face = Vec3d::Zero();  ///< on an edge, where two or three faces meet at right angles: outward normal of one of them
};

/// Mass properties of a shape at a density of 1; of a 2D section, those of a metre of depth.
struct MassProperties {
    double volume = 0;             ///< m^3
    Vec3d centre = Vec3d::Zero();  ///< of gravity, m
    Mat3d moment = Mat3d::Zero();  ///< integral of r r^T about the centre, m^5
    /// Tensor of inertia about the centre at a density of 1 [m^5].
    Mat3d inertia() const { return moment.trace() * Mat3d::Identity() - moment; }
};

/// Mass properties of a closed mesh by the divergence theorem: a sum over the tetrahedra between its triangles and a point.
MassProperties bulk_of(const TriangleMesh& mesh);

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
    /// Whether its cuts across the axis are all the same, between two flat ends.
    virtual bool prismatic(int) const { return false; }
    /// Volume, centre and moments of the inside. This one sums over mesh().
    virtual MassProperties bulk() const { return bulk_of(mesh(0, 0)); }
    /// For drawing. @param edge wanted length of an edge [m] @param extent half-width of a plane's drawn patch [m]
    virtual TriangleMesh mesh(Real edge, Real extent) const = 0;
    /// Points about a spacing apart on the surface at the signed distance `offset` [m] (nearer where the shape is too thin for it).
    /// This one throws darts on mesh(): blue noise; the same for the same shape. @throws InputError beyond 50 million points
    virtual std::vector<SurfaceSample> surface_samples(Real offset, const SamplingRegion& region) const;
    std::vector<std::string> remarks;  ///< parts left out of its mesh file, and faces that cross others
};

/// @throws InputError if a mesh file is missing, unreadable or not closed
std::shared_ptr<const Shape> make_shape(const ShapeKeys& keys);

std::shared_ptr<const Shape> make_box(const Vec3d& min, const Vec3d& max);

std::shared_ptr<const Shape> make_sphere(const Vec3d& centre, double radius);

std::shared_ptr<const Shape> make_cylinder(const Vec3d& from, const Vec3d& to, double radius);

/// Empty if the plane z = 0 cuts the shape in a rectangle or a disc; else the reason, a text that follows the shape's name.
std::string section_error(const ShapeKeys& keys);
/// A rectangle or a disc. Distances and normals lie in the plane, whatever z. @param keys section_error() is empty
std::shared_ptr<const Shape> make_section(const ShapeKeys& keys);

/// The mesh in `file`, times scale, then moved by `position`. @throws InputError
std::shared_ptr<const Shape> make_mesh(const std::filesystem::path& file, double scale, const Vec3d& position);
/// Shape of a mesh in memory. @param name for error messages @throws InputError if the mesh is empty or not closed
std::shared_ptr<const Shape> make_mesh(TriangleMesh mesh, const std::string& name);

}  // namespace whorl
