#include "render/surface/creases.h"

#include <cmath>
#include <numbers>

namespace whorl {

TriangleMesh with_normals(const TriangleMesh& mesh) {
    if (mesh.normal.size() == mesh.position.size()) return mesh;
    const float crease = std::cos(40 * std::numbers::pi_v<float> / 180);
    std::vector<Vec3f> face;  // length: twice the area
    std::vector<std::vector<std::uint32_t>> around(mesh.position.size());
    for (const auto& t : mesh.triangle) {
        for (const std::uint32_t corner : t) around[corner].push_back(static_cast<std::uint32_t>(face.size()));
        face.push_back((mesh.position[t[1]] - mesh.position[t[0]]).cross(mesh.position[t[2]] - mesh.position[t[0]]));
    }
    TriangleMesh split;
    for (std::size_t f = 0; f < mesh.triangle.size(); ++f) {
        const auto first = static_cast<std::uint32_t>(split.position.size());
        for (const std::uint32_t corner : mesh.triangle[f]) {
            Vec3f normal = Vec3f::Zero();
            for (const std::uint32_t other : around[corner])
                if (face[other].dot(face[f]) >= crease * face[other].norm() * face[f].norm()) normal += face[other];
            split.position.push_back(mesh.position[corner]);
            split.normal.push_back(normal.normalized());
        }
        split.triangle.push_back({first, first + 1, first + 2});
    }
    return split;
}

}  // namespace whorl
