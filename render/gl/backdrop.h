#pragma once
/// What the camera sees where nothing stands, kept while camera, look and ground rest: only the light on the ground changes from picture
/// to picture.
#include <functional>
#include <optional>
#include <string>

#include "render/gl/objects.h"

namespace whorl {

class Backdrop {
public:
    /// All that it depends on: it is the same whatever was drawn before.
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
    void draw(const Key& key, const std::string& constants, const std::function<void(gl::Program&)>& prepare, GLuint no_vertices);
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
