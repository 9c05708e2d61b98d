#include "render/export/textured_mesh.h"

#include <Eigen/Geometry>

#include "render/image/image.h"
#include "render/look/texture_places.h"

namespace whorl {

TexturedMesh textured_mesh(const FrameSolid& solid) {
    const TriangleMesh& mesh = *solid.mesh;
    const Appearance& look = solid.appearance;
    TexturedMesh all;
    for (const auto& t : mesh.triangle) {
        const auto first = static_cast<std::uint32_t>(all.mesh.position.size());
        for (const std::uint32_t v : t) all.mesh.position.push_back(mesh.position[v]), all.mesh.normal.push_back(mesh.normal[v]);
        all.mesh.triangle.push_back({first, first + 1, first + 2});
    }
    if (!look.texture_mesh.empty()) all.place = texture_places(mesh, look.texture_mesh);
    for (Eigen::Vector2f& at : all.place) at.y() = 1 - at.y();
    if (!all.place.empty()) return all;

    const Image picture = read_texture(look.texture);
    Eigen::AlignedBox3f bounds;
    for (const Vec3f& x : mesh.position) bounds.extend(x);
    const float width = look.texture_size.value_or(bounds.sizes().maxCoeff());
    const Eigen::Vector2f size(width, width * static_cast<float>(picture.height) / static_cast<float>(picture.width));
    for (const auto& t : all.mesh.triangle) {
        const std::vector<Vec3f>& x = all.mesh.position;
        const Vec3f face = (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]);
        int axis = 0;
        face.cwiseAbs().maxCoeff(&axis);
        const float side = face[axis] < 0 ? -1 : 1;
        for (const std::uint32_t v : t) {
            const Vec3f q = x[v] - bounds.center();
            const Eigen::Vector2f seen = axis == 0   ? Eigen::Vector2f(-side * q.z(), q.y())
                                         : axis == 1 ? Eigen::Vector2f(q.x(), -side * q.z())
                                                     : Eigen::Vector2f(side * q.x(), q.y());
            all.place.emplace_back(0.5f + seen.x() / size.x(), 0.5f - seen.y() / size.y());
        }
    }
    return all;
}

}  // namespace whorl
