#include "render/gl/solid_pictures.h"

#include "render/gl/setup.h"
#include "render/image/image.h"

namespace whorl {
namespace {

gl::Texture texture_of(const Image& image) {
    gl::Texture texture = gl::texture_2d(GL_SRGB8_ALPHA8, image.width, image.height, true);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, image.width, image.height, GL_RGB, GL_UNSIGNED_BYTE, image.rgb.data());
    glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
    for (const GLenum axis : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T}) glTexParameteri(GL_TEXTURE_2D, axis, GL_REPEAT);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
    glGenerateMipmap(GL_TEXTURE_2D);
    return texture;
}

}  // namespace

void SolidPictures::fill(const std::vector<FrameSolid>& solids) {
    for (const FrameSolid& solid : solids) {
        if (solid.appearance.texture.empty() || !solid.mesh) continue;
        if (const auto [place, is_new] = pictures_.try_emplace(solid.appearance.texture.string()); is_new) {
            const Image image = read_texture(solid.appearance.texture);
            place->second = {texture_of(image), static_cast<float>(image.height) / static_cast<float>(image.width)};
        }
        const Bounds bounds = bounds_of(solid.mesh->position);
        extents_.try_emplace(solid.mesh.get(), Extent{solid.mesh, bounds.centre(), (bounds.high - bounds.low).maxCoeff()});
    }
    std::erase_if(extents_, [](const auto& entry) { return entry.second.mesh.use_count() == 1; });
}

void SolidPictures::bind(gl::Program& program, int unit, const FrameSolid& solid) const {
    const Picture& picture = pictures_.at(solid.appearance.texture.string());
    const Extent& extent = extents_.at(solid.mesh.get());
    const float width = solid.appearance.texture_size.value_or(extent.longest);
    program.texture("picture_map", unit, GL_TEXTURE_2D, picture.texture.id());
    program.set("picture_size", Eigen::Vector2f(width, picture.height * width));
    program.set("picture_middle", extent.middle);
}

}  // namespace whorl
