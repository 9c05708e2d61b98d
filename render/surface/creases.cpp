#include "render/surface/creases.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

namespace whorl {
namespace {

/// Cosine of the angle from which on an edge is sharp.
float crease() { return std::cos(40 * std::numbers::pi_v<float> / 180); }

}  // namespace

TriangleMesh with_normals(const TriangleMesh& mesh) {
    if (mesh.normal.size() == mesh.position.size()) return mesh;
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
                if (face[other].dot(face[f]) >= crease() * face[other].norm() * face[f].norm()) normal += face[other];
            split.position.push_back(mesh.position[corner]);
            split.normal.push_back(normal.normalized());
        }
        split.triangle.push_back({first, first + 1, first + 2});
    }
    return split;
}

std::vector<std::pair<Vec3f, Vec3f>> sharp_edges(const TriangleMesh& mesh) {
    using Corner = std::array<float, 3>;
    const auto place = [&](std::uint32_t v) { return Corner{mesh.position[v].x(), mesh.position[v].y(), mesh.position[v].z()}; };
    std::map<std::pair<Corner, Corner>, std::vector<Vec3f>> normals;  // of the faces at each edge; corners that stand in one place are one
    for (const auto& t : mesh.triangle) {
        const Vec3f across = (mesh.position[t[1]] - mesh.position[t[0]]).cross(mesh.position[t[2]] - mesh.position[t[0]]);
        if (across.norm() <= 0) continue;
        for (int c = 0; c < 3; ++c) normals[std::minmax(place(t[c]), place(t[(c + 1) % 3]))].push_back(across.normalized());
    }
    std::vector<std::pair<Vec3f, Vec3f>> edges;
    for (const auto& [ends, faces] : normals)
        if (faces.size() == 1 || (faces.size() == 2 && faces[0].dot(faces[1]) < crease()))
            edges.emplace_back(Vec3f(ends.first[0], ends.first[1], ends.first[2]), Vec3f(ends.second[0], ends.second[1], ends.second[2]));
    return edges;
}

}  // namespace whorl
