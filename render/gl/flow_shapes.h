#pragma once
/// The flow in the memory of the graphics device, and drawn: particles with trails, a slice, tubes and ribbons along vortex lines, a lit
/// cloud.
#include <array>
#include <functional>

#include "render/flow/flow_grid.h"
#include "render/flow/slice.h"
#include "render/gl/objects.h"
#include "render/gl/scene_geometry.h"
#include "render/look/camera.h"
#include "render/look/look_options.h"

namespace whorl {

/// Parameters for drawing the flow.
struct FlowView {
    const LookOptions& look;
    const View& view;
    float spacing;  ///< m
    int width, height;
    /// Sets the studio's uniforms of a program, which it makes the current one.
    std::function<void(gl::Program&)> set_studio;
};

class FlowShapes {
public:
    /// Gives the scene the solids, and the fluid's bounds or particles. @param range of the colour map @param pixels along a slice's longer
    /// side
    void fill(SceneGeometry& scene, const Frame& frame, const LookOptions& look, const View& view, const std::array<float, 2>& range,
              int pixels);
    /// Draws the opaque shapes into the buffer of the solids.
    void draw(const SceneGeometry& scene, const FlowView& flow, const Eigen::Matrix4f& matrix);
    /// The cloud, added to the image over the content of `solids`.
    void shade_cloud(const LookOptions& look, const View& view, const gl::Texture& solids, const Eigen::Matrix4f& matrix, int sample);

private:
    Bounds fill_slice(const FlowSlice& slice);
    Bounds fill_cloud(const FlowGrid& grid, const LookOptions& look, const View& view);

    gl::Program particles_{{"particles.vert"}, {"painted.glsl", "particles.frag"}};
    gl::Program trail_{{"lines.vert"}, {"trail.frag"}};
    gl::Program lines_{{"lines.vert"}, {"painted.glsl", "lines.frag"}};
    gl::Program slice_colour_{{"slice.vert"}, {"slice.frag"}};
    gl::Program volume_{{"screen.vert"}, {"volume.frag"}};
    gl::Vertices trails_{{3, 3}}, tubes_{{3, 3, 3, 1}}, corners_{{3, 2}};
    gl::Texture slice_, cloud_light_, cloud_blocks_;
    int slice_width_ = 0, slice_height_ = 0;
    Bounds cloud_box_;
    Vec3f cloud_cell_ = Vec3f::Ones();  ///< m
    float cloud_thickness_ = 0;         ///< optical depth of a metre of density 1
};

}  // namespace whorl
