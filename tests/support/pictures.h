#pragma once
/// Pictures for tests and benchmarks that need no renderer.
#include "render/image/image.h"

namespace whorl {

/// Mean and largest perceptual difference (CIE76 delta E in L*a*b*, after a 3x3 blur so that one-pixel shifts of an edge count little);
/// infinite if the sizes differ.
struct PictureDifference {
    double mean = 0, p99 = 0, max = 0;
};
PictureDifference difference(const Image& a, const Image& b);

}  // namespace whorl

namespace whorl::test {

/// Soft gradients, shaded balls with sharp outlines and a touch of noise: about as hard to compress as a rendered frame.
Image studio_picture(int width, int height);
Image flat_picture(int width, int height, std::uint8_t r, std::uint8_t g, std::uint8_t b);

}  // namespace whorl::test
