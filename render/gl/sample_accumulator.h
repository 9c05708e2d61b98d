#pragma once
/// Sum of an image's samples. A pixel whose first sample resembles its neighbours is final; later samples skip it.
#include "render/gl/objects.h"

namespace whorl {

class SampleAccumulator {
public:
    /// @param depth with a stencil, in which the code that draws a sample marks its pixels
    SampleAccumulator(int width, int height, const gl::Texture& depth);
    /// Starts an image of `count` samples. @param all whether every pixel needs all of them
    void begin(int count, bool all);
    int count() const { return count_; }
    /// Whether the sample is kept apart until its final pixels are known; leaves_out(): whether it skips those pixels.
    bool may_converge(int sample) const { return sample == 0 && !all_; }
    bool leaves_out(int sample) const { return sample > 0 && !all_; }
    float weight() const { return 1.0f / static_cast<float>(count_); }
    /// Target of a sample, with that stencil; weight(): factor of the sample there.
    GLuint target(int sample) const { return may_converge(sample) ? shaded_first_.id() : shaded_sum_.id(); }
    float weight(int sample) const { return may_converge(sample) ? 1 : weight(); }

    /// Adds the first sample to the sum, and marks the pixels that need no other.
    /// @param glass the glass in front, with the weight of one sample; 0: none
    void mark_converged(GLuint glass);
    /// Fills the depth buffer of a later sample: final pixels get the nearest depth, so that they are not drawn again.
    void mask_converged(const gl::Texture& depth) const;
    /// Completes the glass of final pixels, of which the first sample has drawn a part. @param target glass, with the depth that
    /// mask_converged() has filled
    void complete_glass(const gl::Framebuffer& target) const;
    /// Clears all colours of the bound framebuffer in pixels without depth.
    void clear_background() const;
    GLuint sum() const { return sum_.id(); }

private:
    int width_, height_, count_ = 1;
    GLuint depth_;
    bool all_ = true;
    gl::Programs converged_{{"screen.vert"}, {"mark_converged.frag"}};
    gl::Program clear_{{"screen.vert"}, {"clear_background.frag"}};
    // Depth 0: the pixel is final.
    gl::Texture settled_, sum_, first_;
    gl::Framebuffer sum_target_, shaded_sum_, shaded_first_;
};

}  // namespace whorl
