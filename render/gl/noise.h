#pragma once
/// Values at random on a lattice that repeats: what the textures of solids and of the ground are made of.
#include "render/gl/objects.h"

namespace whorl {

/// 64^3 values between 0 and 1; on every coarser level each is the mean of eight, so that what is finer than a pixel is smooth.
gl::Texture lattice_noise();

}  // namespace whorl
