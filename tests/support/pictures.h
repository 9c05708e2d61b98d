#pragma once
/// Pictures for tests and benchmarks that need no renderer.
#include "render/image/image.h"

namespace whorl::test {

/// Soft gradients, shaded balls with sharp outlines and a little noise: about as hard to compress as a rendered frame.
Image studio_picture(int width, int height);
Image flat_picture(int width, int height, std::uint8_t r, std::uint8_t g, std::uint8_t b);

}  // namespace whorl::test
