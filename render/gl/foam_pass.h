#pragma once
/// Draws spray and foam over the averaged samples of an image: white points, blurred along their path while the shutter is open.
#include <functional>

#include "render/gl/objects.h"
#include "render/look/camera.h"
#include "render/surface/foam.h"

namespace whorl {

/// Parameters for drawing foam.
struct FoamView {
    const View& view;
    const Eigen::Matrix4f& matrix;  ///< world -> clip
    float spacing;                  ///< m
    float open;                     ///< time for which the shutter is open [s]
    Vec3f lamp;                     ///< direction to the light, unit vector
    GLuint normals, solids;         ///< buffers of the fluid and the solids; alpha: distance from the eye [m], 0: none
};

class FoamPass {
public:
    FoamPass(int width, int height) : width_(width), height_(height) {}
    void fill(const Frame& frame, float amount);
    /// @param prepare makes the program current and sets the studio's uniforms
    void draw(GLuint picture, const FoamView& foam, const std::string& constants, const std::function<void(gl::Program&)>& prepare);

private:
    int width_, height_;
    gl::Programs program_{{"foam.vert"}, {"studio.glsl", "field.glsl", "octahedral.glsl", "foam.frag"}};
    gl::Vertices corners_{{3, 3, 4, 1}};
    gl::Framebuffer target_;
    GLuint picture_ = 0;
};

}  // namespace whorl
