#pragma once
/// Blurs an image along the motion of its pixels. Costs as much as a fraction of a sample, and has no steps, unlike images of single
/// moments laid over each other.
#include "render/gl/objects.h"

namespace whorl {

class MotionBlur {
public:
    MotionBlur(int width, int height);
    /// @param picture of RGBA16F, replaced @param motion in pixels while the shutter is open, and the depth [m]
    void blur(GLuint picture, GLuint motion);

private:
    int width_, height_, side_, across_, down_;
    gl::Programs longest_program_{{"screen.vert"}, {"longest.frag"}};
    gl::Program blur_program_{{"screen.vert"}, {"motion_blur.frag"}};
    gl::Texture longest_, spread_, blurred_;
    gl::Framebuffer longest_target_, spread_target_, blurred_target_;
};

}  // namespace whorl
