#include "render/gl/solid_light.h"

namespace whorl {
namespace {

constexpr int coarser = 3;

}  // namespace

SolidLight::SolidLight(int width, int height)
    : width_((width + coarser - 1) / coarser), height_((height + coarser - 1) / coarser),
      light_(gl::texture_2d(GL_RGBA16F, width_, height_, false)), place_(gl::texture_2d(GL_RGBA16F, width_, height_, false)),
      depth_(gl::texture_2d(GL_DEPTH24_STENCIL8, width_, height_, false)),
      target_(gl::framebuffer({light_.id(), place_.id()}, depth_.id())) {}

void SolidLight::begin(const Eigen::Matrix4f& camera, const std::function<void(gl::Program&)>& faces, GLuint no_vertices) {
    camera_ = camera;
    glBindFramebuffer(GL_FRAMEBUFFER, target_.id());
    glViewport(0, 0, width_, height_);
    glClearColor(0, 0, 0, 0);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    glEnable(GL_DEPTH_TEST);
    mask_.use();
    faces(mask_);
    glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    glBindVertexArray(no_vertices);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glDepthFunc(GL_EQUAL);
}

void SolidLight::end() const { glDepthFunc(GL_LESS); }

void SolidLight::bind(gl::Program& program, int unit) const {
    program.texture("light_kept", unit, GL_TEXTURE_2D, light_.id());
    program.texture("place_kept", unit + 1, GL_TEXTURE_2D, place_.id());
    program.set("to_kept", camera_);
}

}  // namespace whorl
