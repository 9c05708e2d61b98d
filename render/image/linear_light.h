#pragma once
/// Pictures in linear light, where averages mean what the eye would see from afar.
#include "engine/core/types.h"
#include "render/image/image.h"

namespace whorl {

/// The light of an sRGB byte, 0 to 1.
float linear_light(std::uint8_t srgb);
/// The nearest sRGB byte of a light, clamped.
std::uint8_t srgb_byte(float light);

}  // namespace whorl
