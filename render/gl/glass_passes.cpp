// Passes of glass: containers in front of the image, and solids that refract it.
#include <algorithm>

#include "render/gl/renderer_device.h"

namespace whorl {

void Renderer::Device::draw_glass(const Shot& shot, const Eigen::Matrix4f& matrix, float weight) {
    glBindFramebuffer(GL_FRAMEBUFFER, glass_target.id());
    glEnable(GL_DEPTH_TEST);
    glDepthMask(GL_FALSE);
    gl::Program& program = glass_walls.with(shot.constants);
    set_studio(program, shot);
    // A wall that the fluid touches lies at the fluid's surface or a little behind it. It is drawn nearer, in front of the fluid.
    const Eigen::Matrix4f before = nearer(matrix, std::min(shot.spacing / (shot.view.target - shot.view.position).norm(), 0.1f));
    program.set("view_projection", before);
    program.set("weight", weight);
    scene.draw_solids(program, true, [](const FrameSolid&) {});
    gl::Program& edges = glass_edges.with(shot.constants);
    set_studio(edges, shot);
    edges.set("view_projection", before);
    edges.set("weight", weight);
    scene.draw_edges(edges);
    glDepthMask(GL_TRUE);
    glDisable(GL_DEPTH_TEST);
}

/// Solids of glass show the finished image, in which the fluid and opaque solids are seen from the frame's camera.
void Renderer::Device::draw_refracted(const Shot& shot, const std::vector<FrameSolid>& solids) {
    if (!glass_pass) glass_pass.emplace(width, height, glass.id());
    compose(shot, glass_pass->seen(), Light::behind_glass);
    scene.go_to(0);
    glBindFramebuffer(GL_FRAMEBUFFER, geometry.id());
    glClearColor(0, 0, 0, 0);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
    glEnable(GL_DEPTH_TEST);
    glScissor(0, 0, width, height);
    draw_faces(shot, shot.camera);
    shade_solids(shot, shot.camera, geometry.id());
    glDisable(GL_SCISSOR_TEST);
    const bool flows = shows_field(shot.look);
    if (!flows) draw_fluid(shot, shot.camera);
    const float flow_behind = flows ? (scene.bounds().centre() - shot.view.position).norm() : 0;
    glass_pass->draw(scene, solids,
                     {shot.camera, samples.count(), shot.lowest() - 1e-4f, geometry.id(), normal.id(), solid.id(), !flows && !field.empty(),
                      flow_behind},
                     shot.constants + gl::constant("clear_fluid", !flows && refracts(shot.material)), [&](gl::Program& program) {
                         set_studio(program, shot);
                         set_body(program, shot.material);
                         field.bind(program, field_unit);
                         solid_field.bind(program, solid_unit);
                     });
}

}  // namespace whorl
