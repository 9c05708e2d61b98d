#pragma once
/// Shapes for blocks of fluid and for solids, given by signed distances.
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "engine/core/mesh.h"
#include "engine/geometry/domain.h"

namespace whorl {

/// A shape as a scene file describes it. kind: box (min, max) | sphere (position, radius) | cylinder (from, to, radius) | capsule (from,
/// to, radius) | cone (from, to, radius, end_radius) | torus (position, axis, radius, tube) | plane (position, normal) | mesh (file, scale,
/// position).
struct ShapeKeys {
    std::string kind = "box";
    Vec3d min = Vec3d::Zero(), max = Vec3d::Ones();
    Vec3d centre = Vec3d::Zero();  ///< sphere, plane, mesh: key "position" of a block. A solid's "position" is instead the expression that
                                   ///< moves it
    double radius = 0;
    Vec3d from = Vec3d::Zero(), to{0, 1, 0};
    double end_radius = 0;  ///< cone: radius at `to` [m]
    Vec3d axis{0, 1, 0};    ///< torus
    double tube = 0;        ///< torus: radius of the tube [m]
    Vec3d normal{0, 1, 0};
    std::filesystem::path file;
    std::string node;  ///< glTF: only the meshes of this node and its children, in its axes; empty: all, as their nodes place them
    double scale = 1;
    std::string open = "none";        ///< side at which a container is open, one of openings(); then the shape is its wall (make_vessel)
    std::optional<double> wall, rim;  ///< of an open container: thickness; height of the rim along the axis of the opening [m]
    bool is_open() const { return open != "none"; }
    /// For 2D flow: use the section of the shape with the plane z = 0, continued for all z. A box or cylinder without depth in z counts as
    /// one that reaches through the plane.
    bool cut = false;
};

/// Region in which a shape's surface needs boundary particles, in the shape's own axes.
struct SamplingRegion {
    Real spacing = 0;      ///< m
    Domain domain;         ///< a box, cylinder or plane that spans a periodic axis has no seam and no ends along it
    Real margin = 0;       ///< width of a margin around the domain that belongs to the region [m]
    bool clipped = false;  ///< whether points beyond the margin are left out
    /// Whether x is within the margin along the axes that are not periodic.
    bool contains(const Vec3d& x) const;
    /// Whether [low, high] covers a whole period of the axis, at any offset.
    bool spans_period(int axis, double low, double high) const;
};

struct SurfaceSample {
    Vec3d position, outward;  ///< m; unit vector, away from the shape's inside
    double curvature = 0;     ///< sum of the principal curvatures [1/m], > 0 if convex; 0 on edges and on meshes
    Vec3d face =
        Vec3d::Zero();     ///< outward normal of one of the faces, on an edge at which two or three faces meet at right angles; elsewhere 0
    bool concave = false;  ///< on such an edge: the faces face each other
};

/// Mass properties of a shape with density 1. In 2D they are per metre of depth.
struct MassProperties {
    double volume = 0;             ///< m^3
    Vec3d centre = Vec3d::Zero();  ///< centre of mass [m]
    Mat3d moment = Mat3d::Zero();  ///< integral of r r^T about the centre, m^5
    /// Tensor of inertia about the centre at a density of 1 [m^5].
    Mat3d inertia() const { return moment.trace() * Mat3d::Identity() - moment; }
};

/// Mass properties of a closed mesh by the divergence theorem: a sum over the tetrahedra between one point and the triangles.
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
    /// Whether all cross-sections perpendicular to the axis are equal, between two flat ends.
    virtual bool prismatic(int) const { return false; }
    /// Whether it is a wall with fluid on both sides, so thick that neither side acts on the other.
    virtual bool shell() const { return false; }
    /// Volume, centre and moments. The default integrates over mesh().
    virtual MassProperties bulk() const { return bulk_of(mesh(0, 0)); }
    /// A mesh for drawing. @param edge requested edge length [m] @param extent half-width of the drawn patch of a plane [m]
    virtual TriangleMesh mesh(Real edge, Real extent) const = 0;
    /// Points about one spacing apart on the surface at signed distance `offset` [m] (nearer to the shape's surface if it is too thin).
    /// The default is blue noise, made by throwing darts on mesh(). Equal shapes get equal points.
    /// @throws InputError beyond 50 million points
    virtual std::vector<SurfaceSample> surface_samples(Real offset, const SamplingRegion& region) const;
    std::vector<std::string> remarks;  ///< notes on parts of its mesh file that were left out, and on faces that intersect others
};

/// @throws InputError if a mesh file is missing, unreadable or not closed
std::shared_ptr<const Shape> make_shape(const ShapeKeys& keys);

std::shared_ptr<const Shape> make_box(const Vec3d& min, const Vec3d& max);

std::shared_ptr<const Shape> make_sphere(const Vec3d& centre, double radius);

std::shared_ptr<const Shape> make_cylinder(const Vec3d& from, const Vec3d& to, double radius);

/// Reason why the section of the shape with the plane z = 0 is neither a rectangle nor a disc, as a text that follows the shape's name.
/// "" if the section is one of these.
std::string section_error(const ShapeKeys& keys);
/// A rectangle or a disc. Its distances and normals lie in the plane z = 0 and do not depend on z.
/// @param keys section_error(keys) must be empty
std::shared_ptr<const Shape> make_section(const ShapeKeys& keys);

/// The mesh in `file`, times `scale`, then moved by `position` [m]. @throws InputError
std::shared_ptr<const Shape> make_mesh(const std::filesystem::path& file, double scale, const Vec3d& position,
                                       const std::string& node = "");
/// Shape of a mesh in memory. @param name for error messages @throws InputError if the mesh is empty or not closed
std::shared_ptr<const Shape> make_mesh(TriangleMesh mesh, const std::string& name);

}  // namespace whorl
