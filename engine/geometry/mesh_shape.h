#pragma once
/// Shape of one triangle mesh.
#include <Eigen/Geometry>
#include <limits>

#include "engine/core/mesh.h"
#include "engine/geometry/shape.h"

namespace whorl {

/// Signed distance to the nearest triangle, found in a tree of boxes. The sign follows from the angle-weighted normal of the nearest
/// corner, edge or face (Baerentzen and Aanaes 2005). This sign is right even if the triangles that share the nearest point give different
/// signs. In a self-intersecting mesh, points with a winding number other than 0 are inside.
class MeshShape final : public Shape {
public:
    explicit MeshShape(TriangleMesh mesh);

    std::ptrdiff_t crossings() const { return crossings_; }
    bool crosses_much() const { return 100 * crossings_ > std::ssize(mesh_.triangle); }
    Real distance(const Vec3& x) const override { return Real(distance(x.cast<double>(), std::numeric_limits<double>::infinity())); }
    /// Signed distance [m]; infinite if its magnitude is not below the bound.
    double distance(const Vec3d& x, double bound) const {
        Vec3d normal, offset;
        return nearest(x, bound, offset, normal);
    }
    bool holds(const Vec3d& x) const { return winding(x) != 0; }
    Vec3 normal(const Vec3& x) const override;
    void bounds(Vec3& min, Vec3& max) const override {
        min = nodes_[0].box.min().cast<Real>();
        max = nodes_[0].box.max().cast<Real>();
    }
    TriangleMesh mesh(Real, Real) const override;
    const Eigen::AlignedBox3d& box() const { return nodes_[0].box; }

private:
    using Triangle = std::array<std::uint32_t, 3>;
    struct Node {
        Eigen::AlignedBox3d box;
        std::uint32_t begin = 0, end = 0;  ///< range of order_, in a leaf
        std::uint32_t right = 0;           ///< index of the right child, 0 in a leaf; the left child follows its parent
    };

    Vec3d area_vector(const Triangle& t) const { return (vertex_[t[1]] - vertex_[t[0]]).cross(vertex_[t[2]] - vertex_[t[0]]); }

    void weigh_normals();
    void find_crossings();
    int winding(const Vec3d& x) const;
    void build(std::vector<std::uint32_t>& order, std::size_t begin, std::size_t end);
    double nearest(const Vec3d& x, double bound, Vec3d& offset, Vec3d& normal) const;

    TriangleMesh mesh_;
    std::vector<Vec3d> vertex_, face_normal_, corner_normal_;
    std::vector<std::array<Vec3d, 3>> edge_normal_;
    std::vector<Node> nodes_;
    std::vector<std::uint32_t> order_;
    std::ptrdiff_t crossings_ = 0;  ///< number of faces whose outer side is inside the mesh
};

}  // namespace whorl
