#pragma once
/// Open vessels: walls of equal thickness around a cavity, with an opening.
#include "engine/geometry/shape.h"

namespace whorl {

/// Sides at which a vessel can be open, in its own axes: top +y, bottom -y, right +x, left -x, front +z, back -z.
const std::vector<std::string>& openings();
/// Unit vector out of the opening. @param open one of openings()
Vec3d opening_direction(const std::string& open);

/// Reason why the shape cannot be an open vessel, as a text that follows the shape's name; "" if it can. @param key receives the key at
/// fault
std::string vessel_error(const ShapeKeys& keys, std::string& key);

/// The wall of a vessel: all points outside the cavity, inside the outer surface, and below the rim.
///   box, cylinder   The cavity is the shape, open at the face towards the opening. The outer surface is a box or cylinder, larger than
///                   the cavity by `wall` at the other faces, so its edges are sharp.
///   sphere          The cavity is the part of the shape below the plane of the rim. The outer surface is a sphere, larger by `wall`.
///   mesh            The cavity is the part of the mesh below the plane of the rim. The outer surface has the mesh's faces moved outward by
///                   `wall`, so its edges are as sharp as the mesh's. (At edges sharper than 19 degrees the wall is thinner.)
/// @param keys open, wall and, for spheres and meshes, rim must be set, and vessel_error() must be empty @throws InputError like
/// make_shape()
std::shared_ptr<const Shape> make_vessel(const ShapeKeys& keys);
/// The vessel of a mesh, open along the unit vector n above the plane through n * rim. @param cavity a closed mesh @param rim, wall m
std::shared_ptr<const Shape> make_mesh_vessel(std::shared_ptr<const Shape> cavity, const Vec3d& n, double rim, double wall);

/// Mass properties of a body with a cavity.
MassProperties hollowed(const MassProperties& whole, const MassProperties& cavity);
/// Distances to an open surface. The sign of the distances and normals has no meaning. @param surface welded
std::shared_ptr<const Shape> make_sheet(TriangleMesh surface);

/// Section of a vessel through its axis, from the axis to the rim: points (s, h), s away from the axis, h along it [m].
struct VesselProfile {
    std::vector<Eigen::Vector2d> outer, inner;  ///< equal numbers of points
    bool round = false;                         ///< the normals are those of circles about (0, 0); otherwise the profile is a polygon
};
/// Mesh of a profile that is swept around the axis. Each side of the sweep has its own two ends.
class VesselSweep {
public:
    /// @param origin of the profile @param n axis, out of the opening
    VesselSweep(const Vec3d& origin, const Vec3d& u, const Vec3d& v, const Vec3d& n) : origin_(origin), u_(u), v_(v), n_(n) {}
    /// Round, with `around` sides.
    TriangleMesh turned(const VesselProfile& profile, int around) const;
    /// With four sides. The profile is a section along u; a section along v is wider by `wider` [m].
    TriangleMesh squared(const VesselProfile& profile, double wider) const;
    /// The section itself, for 2D flow: from -depth to depth [m] along v.
    TriangleMesh extruded(const VesselProfile& profile, double depth) const;

private:
    struct Edge;
    void add_side(const VesselProfile& profile, const Edge& from, const Edge& to, TriangleMesh& mesh) const;
    Vec3d origin_, u_, v_, n_;
};

}  // namespace whorl
