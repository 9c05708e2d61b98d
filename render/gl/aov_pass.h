#pragma once
/// The layers of an image for compositors: its linear light, and in a separate pass, through the centre of every pixel at the frame's
/// time, depth, normal, motion and identity. Created at first use.
#include "render/gl/objects.h"
#include "render/gl/scene_geometry.h"
#include "render/image/exr.h"
#include "render/look/camera.h"

namespace whorl {

/// Scene and cameras of this and of the next image.
struct LayerView {
    Eigen::Matrix4f now, next;  ///< world -> clip
    Vec3f eye, forward;         ///< m; unit
    float interval;             ///< s, simulated, from this picture to the next
    float ground, seen_ground;  ///< m, far below where there is none: what cuts off things, and what is drawn of it
    float tolerance;            ///< m, of the cut through the fluid
    bool turns;                 ///< the backdrop turns with the world
};

class AovPass {
public:
    /// @param depth a buffer of the picture's size that may be overwritten
    AovPass(int width, int height, const gl::Texture& depth);
    /// Targets of the light (0) and the shadow (1).
    const gl::Framebuffer& light_target() const { return light_target_; }
    /// The light, and where there is one the shadow.
    PictureLayers read_light(bool has_shadow) const;
    /// Draws depth, normals, motion and ids.
    void draw_places(const SceneGeometry& scene, const LayerView& view);
    /// The motion in pixels over the interval, and the depth [m], of draw_places().
    GLuint motion_and_depth() const { return motion_and_depth_.id(); }
    /// Adds them to the layers.
    void add_places(PictureLayers& layers, const SceneGeometry& scene, const LayerView& view);

private:
    /// An attachment of the framebuffer that is bound, rows from the top, four numbers a pixel.
    std::vector<float> read(GLenum attachment) const;

    int width_, height_;
    gl::Program things_{{"layers.vert"}, {"layers.frag"}};
    gl::Program behind_{{"screen.vert"}, {"layers_behind.frag"}};
    gl::Texture light_, shadow_, normal_and_number_, motion_and_depth_;
    gl::Framebuffer light_target_, place_target_;
};

}  // namespace whorl
