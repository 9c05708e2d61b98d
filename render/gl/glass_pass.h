#pragma once
/// Solids of glass, drawn in front of the finished image without them.
#include <functional>

#include "render/gl/glass_solids.h"
#include "render/gl/objects.h"
#include "render/gl/scene_geometry.h"

namespace whorl {

/// Parameters for drawing glass.
struct GlassView {
    const Eigen::Matrix4f& camera;  ///< world -> clip
    int samples;                    ///< per pixel
    float lowest;                   ///< height below which nothing is drawn [m]
    GLuint geometry;                ///< framebuffer with the depth of the fluid and of opaque solids
    GLuint fluid, solids;           ///< alpha: their distances from the eye [m], 0: none; red, green, blue: light of the solids
    bool has_fluid;                 ///< the fluid has a distance field
    float behind;                   ///< distance behind the glass at which a flow without a distance field is assumed [m]; 0: none
};

class GlassPass {
public:
    /// @param glass texture that receives the light of the glass times the covered part of a pixel, and this part in alpha
    GlassPass(int width, int height, GLuint glass);
    /// Framebuffer for the image without glass, in linear light. Fill it before draw().
    GLuint seen() const { return seen_target_.id(); }
    /// @param prepare sets the uniforms of the studio, the fluid's field and the opaque solids' field of a program
    void draw(const SceneGeometry& scene, const std::vector<FrameSolid>& solids, const GlassView& view, const std::string& constants,
              const std::function<void(gl::Program&)>& prepare);

private:
    int width_, height_;
    gl::Programs program_{{"mesh.vert"},
                          {"studio.glsl", "textures.glsl", "table.glsl", "field.glsl", "solids.glsl", "inks.glsl", "body.glsl",
                           "solids_of_glass.glsl", "refract.frag"}};
    gl::Program depth_only_{{"mesh.vert"}, {"depth.frag"}};
    gl::Texture seen_, depth_;
    gl::Framebuffer seen_target_, target_;
    GlassSolids glasses_;
};

}  // namespace whorl
