#pragma once
/// Boxes, cylinders, balls and their open vessels, recognised from their meshes.
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "engine/core/mesh.h"

namespace whorl {

/// A ball, or with an axis an infinite cylinder.
struct Round {
    Vec3f centre = Vec3f::Zero();  ///< m
    float radius = 0;              ///< m
    Vec3f axis = Vec3f::Zero();    ///< unit vector; zero: a ball
};

/// Points in all half spaces and in the round body. Empty if it has neither.
struct ConvexBody {
    std::vector<Eigen::Vector4f> planes;  ///< (n, -c): n . x <= c with the outward unit normal n
    std::optional<Round> round;
    bool empty() const { return planes.empty() && !round; }
    /// Signed distance near the surface, negative inside [m]; farther out a lower bound. 1e6 if the body is empty.
    float distance(const Vec3f& x) const;
};

/// A convex body less a convex cavity, as in a vessel.
struct ExactSolid {
    ConvexBody outer, cavity;
    float distance(const Vec3f& x) const { return std::max(outer.distance(x), -cavity.distance(x)); }
};

/// The solid whose surface the mesh approximates; none if it is not of this kind, within 1e-4 of its size. The mesh needs normals:
/// triangles whose normals agree are flat, the others must lie on one convex and one concave ball or cylinder.
std::optional<ExactSolid> exact_solid(const TriangleMesh& mesh);

/// The solid after x -> rotation x + translation.
ExactSolid moved(const ExactSolid& solid, const Mat3f& rotation, const Vec3f& translation);

}  // namespace whorl
