#pragma once
/// Light that reaches the ground and the solids: through the fluid (coloured and focused), past the solids, and from the open sky.
#include <functional>
#include <optional>
#include <vector>

#include "render/gl/objects.h"
#include "render/gl/scene_geometry.h"
#include "render/gl/scene_lighting.h"
#include "render/look/look_options.h"
#include "render/look/material.h"
#include "render/surface/surface.h"

namespace whorl {

/// Buffer of the light that reaches the solids, at a third of the image's resolution (solid_light.glsl).
class SolidLight {
public:
    /// @param width, height of the image [pixels]
    SolidLight(int width, int height);
    /// Binds the buffer. Until end(), gl::draw_screen() draws only texels that show a solid.
    /// @param camera world -> clip @param faces sets the uniforms of faces.glsl
    void begin(const Eigen::Matrix4f& camera, const std::function<void(gl::Program&)>& faces);
    void end() const;
    /// Sets the uniforms of solid_light.glsl; uses texture units `unit` and `unit` + 1.
    void bind(gl::Program& program, int unit) const;

private:
    int width_, height_;
    gl::Program mask_{{"screen.vert"}, {"faces.glsl", "mask.frag"}};
    Eigen::Matrix4f camera_ = Eigen::Matrix4f::Identity();
    gl::Texture light_, place_, depth_;
    gl::Framebuffer target_;
};

/// Shadow maps of the lamps, and the light map of the ground.
class GroundLight {
public:
    /// @param height of the images [pixels]; below 480 the maps have half the resolution, since a small image shows no more
    explicit GroundLight(int height) : light_size(height < 480 ? 128 : 256), ground_size(light_size) {}
    /// Draws the maps of a frame. @param spacing of the particles [m] @param ground height of the ground [m]; none: maps for the light on
    /// the solids only @param constants of studio.glsl
    void draw(const SceneGeometry& scene, const Material& material, const LampLight& light, float spacing, std::optional<float> ground,
              const std::string& constants);
    /// Area of the ground with a light map: centre x, z, half-width [m].
    const Vec3f& area() const { return area_; }
    /// Sets the uniforms of shadow.glsl; uses texture units `unit` and `unit` + 1.
    void bind_shadow(gl::Program& program, int unit) const;
    /// Sets the uniforms of studio.glsl for the ground's light map; uses one texture unit.
    void bind_ground(gl::Program& program, int unit) const;

private:
    const int light_size, ground_size;  ///< texels along a side
    void draw_layers(const SceneGeometry& scene, std::size_t lamp, float spacing);
    void draw_glass(const SceneGeometry& scene);
    void make_maps(std::size_t lamps);
    void draw_transmission(const Material& material, const Vec3f& absorption, bool has_glass);
    void draw_ground(const SceneGeometry& scene, const Vec3f& tint, float ground, float spacing, gl::Program& program);

    gl::Program layers_program_{{"mesh.vert"}, {"light.frag"}};
    gl::Program transmission_program_{{"screen.vert"}, {"transmission.frag"}};
    gl::Program lowest_program_{{"mesh.vert"}, {"lowest.frag"}};
    gl::Program nearness_program_{{"screen.vert"}, {"nearness.frag"}};
    gl::Programs ground_program_{{"screen.vert"}, {"studio.glsl", "shadow.glsl", "ground.frag"}};
    gl::Texture fluid_layers_ = gl::texture_2d(GL_RGBA32F, light_size, light_size, true);
    gl::Texture solid_layers_ = gl::texture_2d(GL_RGBA32F, light_size, light_size, true);
    gl::Texture open_, blockers_;  ///< the lamps' maps, side by side
    gl::Framebuffer transmission_target_;
    std::size_t maps_ = 0;  ///< number of maps in them
    gl::Texture lowest_ = gl::texture_2d(GL_R32F, ground_size, ground_size, false);
    gl::Texture nearness_ = gl::texture_2d(GL_RGBA16F, ground_size, ground_size, true);
    gl::Texture map_ = gl::texture_2d(GL_RGBA16F, ground_size, ground_size, true);
    gl::Texture glass_layers_, glass_depth_;  ///< created for the first solid of glass
    gl::Framebuffer glass_target_;
    gl::Framebuffer layers_target_ = gl::framebuffer({fluid_layers_.id(), solid_layers_.id()}, 0);
    gl::Framebuffer lowest_target_ = gl::framebuffer({lowest_.id()}, 0);
    gl::Framebuffer nearness_target_ = gl::framebuffer({nearness_.id()}, 0);
    gl::Framebuffer map_target_ = gl::framebuffer({map_.id()}, 0);

    LampLight light_;
    Vec3f centre_ = Vec3f::Zero();
    float radius_ = 1;                             ///< radius of the lit scene [m]
    std::vector<Eigen::Matrix4f> light_matrices_;  ///< world -> clip of each lamp's map
    Vec3f area_ = Vec3f(0, 0, 1e-9f);              ///< centre x, z, half-width [m]
};

/// Flat patch of a hot fluid's surface, which lights its surroundings.
struct EmissivePatch {
    Vec3f place = Vec3f::Zero();   ///< mean position, weighted by the emitted light [m]
    Vec3f normal = Vec3f::Zero();  ///< mean over its area; shorter than 1 if the surface is curved
    Vec3f light = Vec3f::Zero();   ///< mean radiance
    float area = 0;                ///< m^2
};

constexpr int most_patches = 32;

/// One patch per cell of a lattice over the surface; only the brightest `most_patches` are kept. Empty if nothing glows.
std::vector<EmissivePatch> hot_patches(const Surface& surface, const Material& material);

/// Sets the uniforms of hot.glsl.
void bind_patches(gl::Program& program, const std::vector<EmissivePatch>& patches);

}  // namespace whorl
