#pragma once
/// Light that reaches the ground and the solids: through the fluid (coloured, gathered), past the solids, and from the open sky.
#include <functional>
#include <vector>

#include "render/gl/objects.h"
#include "render/gl/scene_geometry.h"
#include "render/look/look_options.h"
#include "render/look/material.h"
#include "render/surface/surface.h"

namespace whorl {

class SolidLight {
public:
    /// @param width, height of the picture [pixels]
    SolidLight(int width, int height);
    /// From here on the screen's triangle reaches only the texels that show a solid. @param camera world -> clip @param faces sets the
    /// uniforms of faces.glsl
    void begin(const Eigen::Matrix4f& camera, const std::function<void(gl::Program&)>& faces);
    void end() const;
    /// Sets the uniforms of solid_light.glsl; takes two texture units from `unit` on.
    void bind(gl::Program& program, int unit) const;

private:
    int width_, height_;
    gl::Program mask_{{"screen.vert"}, {"faces.glsl", "mask.frag"}};
    Eigen::Matrix4f camera_ = Eigen::Matrix4f::Identity();
    gl::Texture light_, place_, depth_;
    gl::Framebuffer target_;
};

class GroundLight {
public:
    /// @param height of the pictures [pixels]: a small one shows no more than half the maps' resolution
    explicit GroundLight(int height) : light_size(height < 480 ? 128 : 256), ground_size(light_size) {}
    /// @param lamp unit, towards the one that throws the shadow @param spacing of the particles [m] @param ground its height [m] @param
    /// has_ground else only the solids are lit
    void draw(const SceneGeometry& scene, const Material& material, const Vec3f& lamp, float spacing, float ground, bool has_ground);
    /// Area of the ground with a light map: centre x, z, half-width [m].
    const Vec3f& area() const { return area_; }
    /// Sets the uniforms of shadow.glsl; takes two texture units from `unit` on.
    void bind_shadow(gl::Program& program, int unit) const;
    /// Sets the uniforms of studio.glsl about the ground; takes one texture unit.
    void bind_ground(gl::Program& program, int unit) const;

private:
    const int light_size, ground_size;  ///< texels along a side
    void draw_layers(const SceneGeometry& scene, float spacing);
    void draw_ground(const SceneGeometry& scene, const Vec3f& tint, float ground, float spacing);

    gl::Program layers_program_{{"mesh.vert"}, {"light.frag"}};
    gl::Program transmission_program_{{"screen.vert"}, {"transmission.frag"}};
    gl::Program lowest_program_{{"mesh.vert"}, {"lowest.frag"}};
    gl::Program nearness_program_{{"screen.vert"}, {"nearness.frag"}};
    gl::Program ground_program_{{"screen.vert"}, {"shadow.glsl", "ground.frag"}};
    gl::Texture fluid_layers_ = gl::texture_2d(GL_RGBA32F, light_size, light_size, true);
    gl::Texture solid_layers_ = gl::texture_2d(GL_RGBA32F, light_size, light_size, true);
    gl::Texture open_ = gl::texture_2d(GL_RGBA16F, light_size, light_size, true);
    gl::Texture blockers_ = gl::texture_2d(GL_RGBA32F, light_size, light_size, true);
    gl::Texture lowest_ = gl::texture_2d(GL_R32F, ground_size, ground_size, false);
    gl::Texture nearness_ = gl::texture_2d(GL_RGBA16F, ground_size, ground_size, true);
    gl::Texture map_ = gl::texture_2d(GL_RGBA16F, ground_size, ground_size, true);
    gl::Framebuffer layers_target_ = gl::framebuffer({fluid_layers_.id(), solid_layers_.id()}, 0);
    gl::Framebuffer transmission_target_ = gl::framebuffer({open_.id(), blockers_.id()}, 0);
    gl::Framebuffer lowest_target_ = gl::framebuffer({lowest_.id()}, 0);
    gl::Framebuffer nearness_target_ = gl::framebuffer({nearness_.id()}, 0);
    gl::Framebuffer map_target_ = gl::framebuffer({map_.id()}, 0);

    Vec3f light_ = Vec3f::UnitY(), centre_ = Vec3f::Zero();
    float radius_ = 1;  ///< of the lit scene [m]
    Eigen::Matrix4f light_matrix_ = Eigen::Matrix4f::Identity();
    Vec3f area_ = Vec3f(0, 0, 1e-9f);  ///< centre x, z, half-width [m]
};

/// Light of a hot fluid on its surroundings: its surface as a few flat patches.
struct EmissivePatch {
    Vec3f place = Vec3f::Zero();   ///< m, where its light comes from in the mean
    Vec3f normal = Vec3f::Zero();  ///< mean over its area: shorter than 1 where it is curved
    Vec3f light = Vec3f::Zero();   ///< mean radiance
    float area = 0;                ///< m^2
};

constexpr int most_patches = 32;

/// Cells of a lattice that holds the surface; of more than most_patches the brightest. None where nothing glows.
std::vector<EmissivePatch> hot_patches(const Surface& surface, const Material& material);

/// Sets the uniforms of hot.glsl.
void bind_patches(gl::Program& program, const std::vector<EmissivePatch>& patches);

}  // namespace whorl
