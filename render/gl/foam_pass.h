#pragma once
/// Spray and foam, drawn over the sum of an image's samples: white points, streaked along their motion while the shutter is open.
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
    float open;                     ///< s, of the shutter
    Vec3f lamp;                     ///< direction, unit
    GLuint normals, solids;         ///< distances of the fluid and the solids are in alpha
};

class FoamPass {
public:
    FoamPass(int width, int height) : width_(width), height_(height) {}
    void fill(const Frame& frame, float amount);
    /// @param prepare sets the studio's uniforms of a program, which it makes the current one
    void draw(GLuint picture, const FoamView& foam, const std::string& constants, const std::function<void(gl::Program&)>& prepare);

private:
    int width_, height_;
    gl::Programs program_{{"foam.vert"}, {"studio.glsl", "octahedral.glsl", "foam.frag"}};
    gl::Vertices corners_{{3, 3, 4, 1}};
    gl::Framebuffer target_;
    GLuint picture_ = 0;
};

}  // namespace whorl
