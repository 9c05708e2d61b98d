#pragma once
/// The samples of a picture, added up. Where the first is like the pixels around it, it is the pixel, and the others leave it out.
#include "render/gl/objects.h"

namespace whorl {

class Samples {
public:
    /// @param depth with the stencil by which whoever draws a sample tells its pixels
    Samples(int width, int height, const gl::Texture& depth);
    /// Before the first of `count`. @param all every pixel needs all of them
    void begin(int count, bool all);
    int count() const { return count_; }
    /// Whether a sample stands alone until it is known which pixels it settles; and whether it leaves those out.
    bool settles(int sample) const { return sample == 0 && !all_; }
    bool leaves_out(int sample) const { return sample > 0 && !all_; }
    float weight() const { return 1.0f / static_cast<float>(count_); }
    /// Where a sample is drawn to, with that stencil, and what it is multiplied with there.
    GLuint target(int sample) const { return settles(sample) ? shaded_first_.id() : shaded_sum_.id(); }
    float weight(int sample) const { return settles(sample) ? 1 : weight(); }

    /// Puts the first sample into the sum, and marks the pixels that need no other.
    /// @param glass what stands before it, with the weight of one sample; 0: nothing
    void settle(GLuint glass, GLuint no_vertices);
    /// Fills the depth buffer of a later sample: what has settled is nearer than all that comes, and is drawn no more.
    void leave_settled(const gl::Texture& depth) const;
    /// Gives what has settled all of its glass, of which the first sample has drawn a part. @param target glass, with the depth that
    /// leave_settled() has filled
    void complete_glass(const gl::Framebuffer& target, GLuint no_vertices) const;
    /// Nothing, in all colours of the framebuffer that is bound, where its depth is that of nothing.
    void wipe_open(GLuint no_vertices) const;
    GLuint sum() const { return sum_.id(); }

private:
    void cover(GLuint no_vertices) const;

    int width_, height_, count_ = 1;
    GLuint depth_;
    bool all_ = true;
    gl::Programs settling_{{"screen.vert"}, {"settle.frag"}};
    gl::Program wipe_{{"screen.vert"}, {"wipe.frag"}};
    // Depth 0 where a pixel has all that it needs.
    gl::Texture settled_, sum_, first_;
    gl::Framebuffer sum_target_, shaded_sum_, shaded_first_;
};

}  // namespace whorl
