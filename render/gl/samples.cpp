#include "render/gl/samples.h"

#include <algorithm>

namespace whorl {

Samples::Samples(int width, int height)
    : width_(width), height_(height), settled_(gl::texture_2d(GL_DEPTH24_STENCIL8, width, height, false)),
      sum_(gl::texture_2d(GL_RGBA16F, width, height, false)), sum_target_(gl::framebuffer({sum_.id()}, settled_.id())) {}

void Samples::cover(GLuint no_vertices) const {
    glBindVertexArray(no_vertices);
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

void Samples::begin(int count, bool all) {
    count_ = std::max(count, 1), all_ = all;
    if (!all && first_.id() == 0) {
        first_ = gl::texture_2d(GL_RGBA16F, width_, height_, false);
        first_target_ = gl::framebuffer({first_.id()}, settled_.id());
    }
    glClearColor(0, 0, 0, 0);
    for (const GLuint target : {sum_target_.id(), first_target_.id()}) {
        if (target == 0) continue;
        glBindFramebuffer(GL_FRAMEBUFFER, target);
        glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
    }
}

void Samples::settle(GLuint glass, GLuint no_vertices) {
    glBindFramebuffer(GL_FRAMEBUFFER, sum_target_.id());
    glEnable(GL_DEPTH_TEST);
    for (const bool settles : {true, false}) {
        gl::Program& program = settling_.with(settles ? "const bool settles = true;\n" : "const bool settles = false;\n");
        program.use();
        program.texture("first", 0, GL_TEXTURE_2D, first_.id());
        program.texture("glass", 1, GL_TEXTURE_2D, glass);
        program.set("has_glass", glass != 0 ? 1 : 0);
        program.set("weight", weight());
        glDepthMask(settles ? GL_TRUE : GL_FALSE);
        if (settles) glDepthRangef(0, 0);
        cover(no_vertices);
        glDepthRangef(0, 1);
    }
    glDepthMask(GL_TRUE);
    glDisable(GL_DEPTH_TEST);
}

void Samples::leave_settled(const gl::Texture& depth) const {
    glCopyImageSubData(settled_.id(), GL_TEXTURE_2D, 0, 0, 0, 0, depth.id(), GL_TEXTURE_2D, 0, 0, 0, 0, width_, height_, 1);
}

void Samples::complete_glass(const gl::Framebuffer& target, GLuint no_vertices) const {
    glBindFramebuffer(GL_FRAMEBUFFER, target.id());
    glEnable(GL_BLEND);
    const auto all = static_cast<float>(count_);
    glBlendColor(all, all, all, all);
    glBlendFunc(GL_ZERO, GL_CONSTANT_COLOR);
    glDepthMask(GL_FALSE);
    glDepthFunc(GL_GREATER);
    wipe_.use();
    cover(no_vertices);
    glDepthFunc(GL_LESS);
    glDepthMask(GL_TRUE);
    glDisable(GL_BLEND);
}

void Samples::wipe_open(GLuint no_vertices) const {
    glDepthMask(GL_FALSE);
    glDepthFunc(GL_LEQUAL);
    glDepthRangef(1, 1);
    wipe_.use();
    cover(no_vertices);
    glDepthRangef(0, 1);
    glDepthFunc(GL_LESS);
    glDepthMask(GL_TRUE);
}

}  // namespace whorl
