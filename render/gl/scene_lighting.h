#pragma once
/// Surroundings that light a scene: the studio or a picture, and the ground.
#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "render/gl/objects.h"
#include "render/look/environment.h"
#include "render/look/look_options.h"

namespace whorl {

class SceneLighting {
public:
    SceneLighting();
    /// Reads the picture of the look, where it has one that is not read yet. @throws InputError if it cannot be read
    void fill(const LookOptions& look);
    /// The studio of the look's background, with the picture's light if there is one.
    Studio studio(const LookOptions& look) const;
    /// Towards the lamp that throws the shadow, unit, in the world's axes.
    Vec3f shadow_lamp(const View& view) const;
    /// Constants of the shaders studio.glsl and table.glsl.
    std::string constants(const LookOptions& look) const;
    /// Sets the uniforms of studio.glsl, textures.glsl and table.glsl but those of the ground's light; takes two texture units from `unit`
    /// on.
    /// @param ground its height [m] @param height of the picture [pixels]
    void bind(gl::Program& program, const LookOptions& look, const View& view, float ground, int height, int unit) const;

private:
    gl::Texture noise_, picture_;
    std::filesystem::path file_;  ///< of the picture; empty: none
    std::array<Vec3f, 9> light_;
};

/// 64^3 values between 0 and 1; on every coarser level each is the mean of eight, so that detail finer than a pixel is smooth.
gl::Texture lattice_noise();

/// The empty background, cached while camera, look and ground do not change: only the light on the ground changes from image
/// to image.
class Backdrop {
public:
    /// All dependencies: earlier images have no influence.
    struct Key {
        Mat3f to_ray;  ///< place in the picture (-1 .. 1, -1 .. 1, 1) -> direction
        Mat3f studio;  ///< world -> studio
        Vec3f eye;     ///< m
        float fov;     ///< degrees
        std::string background, table, environment;
        float ground;  ///< m
        Vec3f area;    ///< of the ground's light map, where a table ends round it
        bool operator==(const Key&) const = default;
    };

    Backdrop(int width, int height);
    /// Draws it where the key is another. @param prepare sets the uniforms of studio.glsl, textures.glsl and table.glsl
    void draw(const Key& key, const std::string& constants, const std::function<void(gl::Program&)>& prepare);
    /// Sets the uniforms of paper.glsl; takes one texture unit.
    void bind(gl::Program& program, int unit) const;

private:
    int width_, height_;
    std::optional<Key> key_;
    gl::Programs program_{{"screen.vert"}, {"studio.glsl", "textures.glsl", "table.glsl", "backdrop.frag"}};
    gl::Texture paper_;
    gl::Framebuffer target_;
};

}  // namespace whorl
