#pragma once
/// Sum of an image's samples. A pixel whose first sample resembles its neighbours is final; later samples skip it.
#include "render/gl/objects.h"

namespace whorl {

class SampleAccumulator {
public:
    /// @param depth depth and stencil buffer; the code that draws a sample marks its pixels in the stencil
    SampleAccumulator(int width, int height, const gl::Texture& depth);
    /// Starts an image of `count` samples. @param all whether every pixel needs all samples
    void begin(int count, bool all);
    int count() const { return count_; }
    /// Whether the sample is stored separately until its final pixels are known.
    bool may_converge(int sample) const { return sample == 0 && !all_; }
    /// Whether the sample skips final pixels.
    bool leaves_out(int sample) const { return sample > 0 && !all_; }
    /// Weight of one sample in a pixel that gets all samples.
    float weight() const { return 1.0f / static_cast<float>(count_); }
    /// Framebuffer of a sample, with the stencil of `depth`.
    GLuint target(int sample) const { return may_converge(sample) ? shaded_first_.id() : shaded_sum_.id(); }
    /// Factor of a sample in its framebuffer.
    float weight(int sample) const { return may_converge(sample) ? 1 : weight(); }

    /// Adds the first sample to the sum and marks the final pixels, which need no other sample.
    /// @param glass texture of the glass in front, with the weight of one sample; 0: none
    void mark_converged(GLuint glass);
    /// Fills the depth buffer of a later sample: final pixels get the nearest depth, so that they are not drawn again.
    void mask_converged(const gl::Texture& depth) const;
    /// Multiplies the glass of final pixels, which only the first sample has drawn, by the number of samples.
    /// @param target framebuffer of the glass, with the depth buffer that mask_converged() has filled
    void complete_glass(const gl::Framebuffer& target) const;
    /// Clears all colours of the bound framebuffer in pixels where nothing is drawn (depth 1).
    void clear_background() const;
    GLuint sum() const { return sum_.id(); }

private:
    int width_, height_, count_ = 1;
    GLuint depth_;
    bool all_ = true;
    gl::Programs converged_{{"screen.vert"}, {"mark_converged.frag"}};
    gl::Program clear_{{"screen.vert"}, {"clear_background.frag"}};
    // Depth 0 in settled_ marks a final pixel.
    gl::Texture settled_, sum_, first_;
    gl::Framebuffer sum_target_, shaded_sum_, shaded_first_;
};

}  // namespace whorl
