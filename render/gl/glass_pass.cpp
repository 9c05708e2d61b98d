#include "render/gl/glass_pass.h"

#include <algorithm>

namespace whorl {
namespace {

/// Whether the bounds of one of the solids are inside those of a glass.
bool any_inside(const std::vector<FrameSolid>& solids, const std::vector<FrameSolid>& glasses) {
    return std::any_of(solids.begin(), solids.end(), [&](const FrameSolid& solid) {
        const Bounds in = bounds_of(solid);
        return std::any_of(glasses.begin(), glasses.end(), [&](const FrameSolid& glass) {
            const Bounds out = bounds_of(glass);
            return (in.low.array() > out.low.array()).all() && (in.high.array() < out.high.array()).all();
        });
    });
}

}  // namespace

GlassPass::GlassPass(int width, int height, GLuint glass)
    : width_(width), height_(height), seen_(gl::texture_2d(GL_RGBA16F, width, height, true)),
      depth_(gl::texture_2d(GL_DEPTH24_STENCIL8, width, height, false)), seen_target_(gl::framebuffer({seen_.id()}, 0)),
      target_(gl::framebuffer({glass}, depth_.id())), glasses_(height) {}

void GlassPass::draw(const SceneGeometry& scene, const std::vector<FrameSolid>& solids, const GlassView& view, const std::string& constants,
                     const std::function<void(gl::Program&)>& prepare) {
    // In the order in which scene draws them.
    std::vector<FrameSolid> drawn, opaque;
    for (const FrameSolid& solid : solids)
        if (solid.mesh && !is_level_ground(solid) && !solid.container) (is_glass(solid) ? drawn : opaque).push_back(solid);
    glasses_.fill(drawn);
    gl::Program& program = program_.with(constants + glasses_.constants() + gl::constant("solids_inside", any_inside(opaque, drawn)));
    prepare(program);
    program.texture("seen", 0, GL_TEXTURE_2D, seen_.id());
    program.texture("fluid_distance", 1, GL_TEXTURE_2D, view.fluid);
    program.texture("solid_buffer", 2, GL_TEXTURE_2D, view.solids);
    glasses_.bind(program, 3);
    program.set("to_clip", view.camera);
    program.set("has_fluid", view.has_fluid ? 1 : 0);
    program.set("behind", view.behind);
    program.set("weight", 1.0f / static_cast<float>(view.samples));
    const auto begin = [&](gl::Program& with, const Eigen::Matrix4f& matrix) {
        with.use();
        with.set("view_projection", matrix);
        with.set("cuts", 1);
        with.set("lowest", view.lowest);
    };
    glEnable(GL_DEPTH_TEST);
    glEnable(GL_CULL_FACE);
    glEnable(GL_CLIP_DISTANCE0);
    for (int k = 0; k < view.samples; ++k) {
        const Eigen::Matrix4f matrix = jittered(view.camera, sample_place(k, view.samples), width_, height_);
        glBindFramebuffer(GL_READ_FRAMEBUFFER, view.geometry);
        glBindFramebuffer(GL_DRAW_FRAMEBUFFER, target_.id());
        glBlitFramebuffer(0, 0, width_, height_, 0, 0, width_, height_, GL_DEPTH_BUFFER_BIT, GL_NEAREST);
        glBindFramebuffer(GL_FRAMEBUFFER, target_.id());
        // Only the front of the glass is shaded: its depth comes first.
        glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
        begin(depth_only_, matrix);
        scene.draw_glass(depth_only_, [](const FrameSolid&) {});
        glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
        glDepthFunc(GL_EQUAL);
        glEnable(GL_BLEND);
        glBlendFunc(GL_ONE, GL_ONE);
        begin(program, matrix);
        std::size_t next = 0;
        scene.draw_glass(program, [&](const FrameSolid&) { program.set("drawn", glasses_.numbers()[next++]); });
        glDisable(GL_BLEND);
        glDepthFunc(GL_LESS);
    }
    glDisable(GL_CLIP_DISTANCE0);
    glDisable(GL_CULL_FACE);
    glDisable(GL_DEPTH_TEST);
}

}  // namespace whorl
