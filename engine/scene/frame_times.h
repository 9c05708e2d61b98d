#pragma once
/// When a film's frames are taken.
#include "engine/scene/scene.h"

namespace whorl {

/// Frame k shows the time (k - 1) frame_interval(); frame 1 the start.
double frame_time(const Scene& scene, int frame);
/// The last frame that is not past time.end.
int frame_count(const Scene& scene);

}  // namespace whorl
