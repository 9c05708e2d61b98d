#pragma once
/// How different two pictures look.
#include "render/image/image.h"

namespace whorl {

/// Mean and largest perceptual difference (CIE76 delta E in L*a*b*, after a 3x3 blur so that one-pixel shifts of an edge count little);
/// infinite where the sizes differ.
struct PictureDifference {
    double mean = 0, p99 = 0, max = 0;
};
PictureDifference difference(const Image& a, const Image& b);

}  // namespace whorl
