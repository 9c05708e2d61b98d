#include "engine/scene/frame_times.h"

#include <cmath>

namespace whorl {

double frame_time(const Scene& scene, int frame) { return (frame - 1) * scene.time.frame_interval(); }

int frame_count(const Scene& scene) {
    // A hair more than the product, for ends that are a whole number of frames up to rounding.
    return static_cast<int>(std::floor(scene.time.end / scene.time.frame_interval() * (1 + 1e-12) + 1e-9)) + 1;
}

}  // namespace whorl
