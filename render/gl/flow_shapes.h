#pragma once
/// Drawing of the flow: particles with trails, a slice, tubes or ribbons along vortex lines, or a lit cloud.
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
    /// Makes a program the current one and sets its uniforms of the studio.
    std::function<void(gl::Program&)> set_studio;
};

class FlowShapes {
public:
    /// Prepares the shapes of the look's style. Fills the scene with the solids, and with the fluid's particles or bounds.
    /// @param range of the colour map @param pixels along the longer side of a slice
    void fill(SceneGeometry& scene, const Frame& frame, const LookOptions& look, const View& view, const std::array<float, 2>& range,
              int pixels);
    /// Draws the opaque shapes into the buffer of the solids.
    void draw(const SceneGeometry& scene, const FlowView& flow, const Eigen::Matrix4f& matrix);
    /// Adds the cloud in front of the content of `solids` to the bound image. @param sample index of the sample within a pixel
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
    float cloud_thickness_ = 0;         ///< optical depth per length at density 1 [1/m]
};

}  // namespace whorl
