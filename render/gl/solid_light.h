#pragma once
/// How much of the light from round about comes to the solids that are seen, in a picture of a third of the resolution (solid_light.glsl).
#include "render/gl/objects.h"

namespace whorl {

class SolidLight {
public:
    /// @param width, height of the picture [pixels]
    SolidLight(int width, int height);
    /// From here on things are drawn into it. @param camera world -> clip
    void begin(const Eigen::Matrix4f& camera);
    /// Sets the uniforms of solid_light.glsl; takes two texture units from `unit` on.
    void bind(gl::Program& program, int unit) const;

private:
    int width_, height_;
    Eigen::Matrix4f camera_ = Eigen::Matrix4f::Identity();
    gl::Texture light_, place_, depth_;
    gl::Framebuffer target_;
};

}  // namespace whorl
