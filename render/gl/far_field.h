#pragma once
/// The distance volume knows distances in a narrow band only. Shadow, occlusion and long leaps need them everywhere, but roughly.
#include "render/surface/surface.h"

namespace whorl {

/// A volume with `coarseness` times larger voxels, `margin` of them wider on every side, whose values are signed distances without a band
/// [m], good to about half a coarse voxel.
Volume far_field(const Volume& band, int coarseness, int margin);

}  // namespace whorl
