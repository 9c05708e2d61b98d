#pragma once
/// The light that a hot fluid throws on what stands about it: its surface as a few flat patches.
#include <vector>

#include "render/gl/objects.h"
#include "render/look/material.h"
#include "render/surface/surface.h"

namespace whorl {

struct HotPatch {
    Vec3f place = Vec3f::Zero();   ///< m, where its light comes from in the mean
    Vec3f normal = Vec3f::Zero();  ///< mean over its area: shorter than 1 where it is curved
    Vec3f light = Vec3f::Zero();   ///< mean radiance
    float area = 0;                ///< m^2
};

constexpr int most_patches = 32;

/// Cells of a lattice that holds the surface; of more than most_patches the brightest. None where nothing glows.
std::vector<HotPatch> hot_patches(const Surface& surface, const Material& material);

/// Sets the uniforms of hot.glsl.
void bind_patches(gl::Program& program, const std::vector<HotPatch>& patches);

}  // namespace whorl
