#pragma once
/// Layers of an image for compositors. Linear light and shadow come from the image's samples. A separate pass draws depth, normal, motion
/// and object number at the centre of each pixel, at the frame's time.
#include "render/gl/objects.h"
#include "render/gl/scene_geometry.h"
#include "render/image/exr.h"
#include "render/look/camera.h"

namespace whorl {

/// Cameras of this image and of the next, and the ground.
struct LayerView {
    Eigen::Matrix4f now, next;  ///< world -> clip, in this image and in the next
    Vec3f eye, forward;         ///< position of the camera [m] and direction of view, unit
    float interval;             ///< simulated time from this image to the next [s]
    float ground, seen_ground;  ///< heights at which objects are cut off, and of the drawn ground [m]; -1e6: none
    float tolerance;            ///< the fluid is cut this far below the ground [m]
    bool turns;                 ///< the backdrop is a panorama, fixed in the world instead of in the image
};

class AovPass {
public:
    /// @param depth depth buffer of the image's size; drawing overwrites it
    AovPass(int width, int height, const gl::Texture& depth);
    /// Framebuffer of the light (attachment 0) and of the shadow (1).
    const gl::Framebuffer& light_target() const { return light_target_; }
    /// Reads the light, and the shadow if `has_shadow`, from light_target().
    PictureLayers read_light(bool has_shadow) const;
    /// Draws depth, normals, motion and object numbers.
    void draw_places(const SceneGeometry& scene, const LayerView& view);
    /// Texture of draw_places(): motion over the interval [pixels] in x and y, depth [m] in z.
    GLuint motion_and_depth() const { return motion_and_depth_.id(); }
    /// Calls draw_places() and adds depth, normals, motion and object numbers to the layers.
    void add_places(PictureLayers& layers, const SceneGeometry& scene, const LayerView& view);

private:
    /// Reads an attachment of the bound framebuffer: rows from the top, four values per pixel.
    std::vector<float> read(GLenum attachment) const;

    int width_, height_;
    gl::Program things_{{"layers.vert"}, {"layers.frag"}};
    gl::Program behind_{{"screen.vert"}, {"layers_behind.frag"}};
    gl::Texture light_, shadow_, normal_and_number_, motion_and_depth_;
    gl::Framebuffer light_target_, place_target_;
};

}  // namespace whorl
