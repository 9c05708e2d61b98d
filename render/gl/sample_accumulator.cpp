#include "render/gl/sample_accumulator.h"

#include <algorithm>

namespace whorl {

SampleAccumulator::SampleAccumulator(int width, int height, const gl::Texture& depth)
    : width_(width), height_(height), depth_(depth.id()), settled_(gl::texture_2d(GL_DEPTH24_STENCIL8, width, height, false)),
      sum_(gl::texture_2d(GL_RGBA16F, width, height, false)), sum_target_(gl::framebuffer({sum_.id()}, settled_.id())),
      shaded_sum_(gl::framebuffer({sum_.id()}, depth_)) {}

void SampleAccumulator::begin(int count, bool all) {
    count_ = std::max(count, 1), all_ = all;
    if (!all && first_.id() == 0) {
        first_ = gl::texture_2d(GL_RGBA16F, width_, height_, false);
        shaded_first_ = gl::framebuffer({first_.id()}, depth_);
    }
    glClearColor(0, 0, 0, 0);
    glBindFramebuffer(GL_FRAMEBUFFER, sum_target_.id());
    glClear(GL_COLOR_BUFFER_BIT | (all ? 0 : GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT));
    if (all) return;
    glBindFramebuffer(GL_FRAMEBUFFER, shaded_first_.id());
    glClear(GL_COLOR_BUFFER_BIT);
}

void SampleAccumulator::mark_converged(GLuint glass) {
    glBindFramebuffer(GL_FRAMEBUFFER, sum_target_.id());
    glEnable(GL_DEPTH_TEST);
    for (const bool may_converge : {true, false}) {
        gl::Program& program = converged_.with(gl::constant("settles", may_converge) + gl::constant("has_glass", glass != 0));
        program.use();
        program.texture("first", 0, GL_TEXTURE_2D, first_.id());
        program.texture("glass", 1, GL_TEXTURE_2D, glass);
        program.set("weight", weight());
        glDepthMask(may_converge ? GL_TRUE : GL_FALSE);
        if (may_converge) glDepthRangef(0, 0);
        gl::draw_screen();
        glDepthRangef(0, 1);
    }
    glDepthMask(GL_TRUE);
    glDisable(GL_DEPTH_TEST);
}

void SampleAccumulator::mask_converged(const gl::Texture& depth) const {
    glCopyImageSubData(settled_.id(), GL_TEXTURE_2D, 0, 0, 0, 0, depth.id(), GL_TEXTURE_2D, 0, 0, 0, 0, width_, height_, 1);
}

void SampleAccumulator::complete_glass(const gl::Framebuffer& target) const {
    glBindFramebuffer(GL_FRAMEBUFFER, target.id());
    glEnable(GL_BLEND);
    const auto all = static_cast<float>(count_);
    glBlendColor(all, all, all, all);
    glBlendFunc(GL_ZERO, GL_CONSTANT_COLOR);
    glDepthMask(GL_FALSE);
    glDepthFunc(GL_GREATER);
    clear_.use();
    gl::draw_screen();
    glDepthFunc(GL_LESS);
    glDepthMask(GL_TRUE);
    glDisable(GL_BLEND);
}

void SampleAccumulator::clear_background() const {
    glDepthMask(GL_FALSE);
    glDepthFunc(GL_LEQUAL);
    glDepthRangef(1, 1);
    clear_.use();
    gl::draw_screen();
    glDepthRangef(0, 1);
    glDepthFunc(GL_LESS);
    glDepthMask(GL_TRUE);
}

}  // namespace whorl
