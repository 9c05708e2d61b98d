#include "render/gl/motion_blur.h"

#include <algorithm>

namespace whorl {

MotionBlur::MotionBlur(int width, int height)
    : width_(width), height_(height), side_(std::max(height / 24, 4)), across_((width + side_ - 1) / side_),
      down_((height + side_ - 1) / side_), longest_(gl::texture_2d(GL_RGBA16F, across_, down_, false)),
      spread_(gl::texture_2d(GL_RGBA16F, across_, down_, false)), blurred_(gl::texture_2d(GL_RGBA16F, width, height, false)),
      longest_target_(gl::framebuffer({longest_.id()}, 0)), spread_target_(gl::framebuffer({spread_.id()}, 0)),
      blurred_target_(gl::framebuffer({blurred_.id()}, 0)) {}

void MotionBlur::blur(GLuint picture, GLuint motion) {
    glViewport(0, 0, across_, down_);
    for (const bool of_squares : {false, true}) {
        glBindFramebuffer(GL_FRAMEBUFFER, (of_squares ? spread_target_ : longest_target_).id());
        gl::Program& program = longest_program_.with(gl::constant("of_squares", of_squares));
        program.use();
        program.texture("motion", 0, GL_TEXTURE_2D, of_squares ? longest_.id() : motion);
        program.set("side", side_);
        gl::draw_screen();
    }
    gl::draw_into(blurred_target_, width_, height_);
    blur_program_.use();
    blur_program_.texture("picture", 0, GL_TEXTURE_2D, picture);
    blur_program_.texture("motion", 1, GL_TEXTURE_2D, motion);
    blur_program_.texture("longest", 2, GL_TEXTURE_2D, spread_.id());
    blur_program_.set("side", side_);
    gl::draw_screen();
    glCopyImageSubData(blurred_.id(), GL_TEXTURE_2D, 0, 0, 0, 0, picture, GL_TEXTURE_2D, 0, 0, 0, 0, width_, height_, 1);
}

}  // namespace whorl
