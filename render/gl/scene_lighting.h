#pragma once
/// Surroundings that light a scene: the studio or a panorama, and the ground.
#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "render/gl/objects.h"
#include "render/look/environment.h"
#include "render/look/lamps.h"
#include "render/look/look_options.h"

namespace whorl {

constexpr float surround_lamp_size = 0.16f;  ///< tangent of the angular radius of the surround's lamp: sets how fast shadows soften
constexpr float key_share = 0.55f;           ///< fraction of the light on open ground that comes from the surround's lamp

/// The lamps that cast shadows.
struct LampLight {
    std::vector<Lamp> lamps;  ///< those of the look or, if it has none, the surround's
    bool named = false;       ///< they are the look's
    float share = 0;          ///< lamp_share of studio.glsl
    /// Sets the uniforms of studio.glsl that describe the look's lamps.
    void bind(gl::Program& program) const;
};

class SceneLighting {
public:
    SceneLighting();
    /// Reads the look's panorama, if it has one that is not read yet. @throws InputError if it cannot be read
    void fill(const LookOptions& look);
    /// The studio of the look's background, with the light of the panorama if there is one.
    Studio studio(const LookOptions& look) const;
    /// Direction towards the surround's lamp, which casts the shadow, unit, in the world's axes.
    Vec3f shadow_lamp(const LookOptions& look, const View& view) const;
    LampLight lamps(const LookOptions& look, const View& view) const;
    /// GLSL constants of studio.glsl and table.glsl.
    std::string constants(const LookOptions& look) const;
    /// Sets the uniforms of studio.glsl, textures.glsl and table.glsl, except those of the ground's light map; uses texture units `unit`
    /// and `unit` + 1.
    /// @param ground height of the ground [m] @param height of the image [pixels]
    void bind(gl::Program& program, const LookOptions& look, const View& view, float ground, int height, int unit) const;

private:
    gl::Texture noise_, picture_;
    std::filesystem::path file_;  ///< of the panorama; empty: none
    std::array<Vec3f, 9> light_;  ///< light_of() the panorama
};

/// Texture of 64^3 random values between 0 and 1. On each coarser mip level a value is the mean of eight, so that detail finer than a pixel
/// is averaged.
gl::Texture lattice_noise();

/// Background of an empty scene, cached while camera, look and ground do not change. compose.frag adds the light on the ground, which
/// changes from image to image.
class Backdrop {
public:
    /// Everything that the background depends on, so that earlier images have no influence.
    struct Key {
        Mat3f to_ray;  ///< position in the image (-1 .. 1, -1 .. 1, 1) -> direction
        Mat3f studio;  ///< world -> studio
        Vec3f eye;     ///< m
        float fov;     ///< degrees
        std::string background, table, environment;
        std::array<float, 2> surround;  ///< strength, turn [degrees]
        std::vector<Light> lights;
        float ground;  ///< m
        Vec3f area;    ///< of the ground's light map: a table ends around it
        bool operator==(const Key&) const = default;
    };

    Backdrop(int width, int height);
    /// Draws the background if the key has changed. @param prepare sets the uniforms of studio.glsl, textures.glsl and table.glsl
    void draw(const Key& key, const std::string& constants, const std::function<void(gl::Program&)>& prepare);
    /// Sets `paper`, `to_ground` and `to_paper` of compose.frag and behind.frag; uses one texture unit.
    void bind(gl::Program& program, int unit) const;

private:
    int width_, height_;
    std::optional<Key> key_;
    gl::Programs program_{{"screen.vert"}, {"studio.glsl", "textures.glsl", "table.glsl", "backdrop.frag"}};
    gl::Texture paper_;
    gl::Framebuffer target_;
};

}  // namespace whorl
