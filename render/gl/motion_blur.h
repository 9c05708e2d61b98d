#pragma once
/// Blurs an image along the motion of its pixels. This costs a fraction of a sample. Unlike an average of images at several moments, the
/// result shows no steps.
#include "render/gl/objects.h"

namespace whorl {

class MotionBlur {
public:
    MotionBlur(int width, int height);
    /// @param picture RGBA16F texture, replaced by the result @param motion texture: motion while the shutter is open [pixels] in x and y,
    /// depth [m] in z
    void blur(GLuint picture, GLuint motion);

private:
    int width_, height_, side_, across_, down_;
    gl::Programs longest_program_{{"screen.vert"}, {"longest.frag"}};
    gl::Program blur_program_{{"screen.vert"}, {"motion_blur.frag"}};
    gl::Texture longest_, spread_, blurred_;
    gl::Framebuffer longest_target_, spread_target_, blurred_target_;
};

}  // namespace whorl
