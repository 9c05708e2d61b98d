#pragma once
/// How much of the light from round about comes to the solids that are seen, in a picture of a third of the resolution (solid_light.glsl).
#include <functional>

#include "render/gl/objects.h"

namespace whorl {

class SolidLight {
public:
    /// @param width, height of the picture [pixels]
    SolidLight(int width, int height);
    /// From here on the screen's triangle reaches only the texels that show a solid. @param camera world -> clip @param faces sets the
    /// uniforms of faces.glsl
    void begin(const Eigen::Matrix4f& camera, const std::function<void(gl::Program&)>& faces, GLuint no_vertices);
    void end() const;
    /// Sets the uniforms of solid_light.glsl; takes two texture units from `unit` on.
    void bind(gl::Program& program, int unit) const;

private:
    int width_, height_;
    gl::Program mask_{{"screen.vert"}, {"faces.glsl", "mask.frag"}};
    Eigen::Matrix4f camera_ = Eigen::Matrix4f::Identity();
    gl::Texture light_, place_, depth_;
    gl::Framebuffer target_;
};

}  // namespace whorl
