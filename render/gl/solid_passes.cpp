// Passes of opaque solids: their faces, their light, their colour.
#include <Eigen/LU>

#include "render/gl/renderer_device.h"

namespace whorl {

void Renderer::Device::find_solid_light(const Shot& shot, const Eigen::Matrix4f& matrix) {
    if (!scene.any_solids()) return;
    glDisable(GL_SCISSOR_TEST);
    solid_light.begin(shot.camera, [&](gl::Program& program) { bind_faces(program); });
    gl::Program& program = solid_light_program.with(shot.constants + gl::constant("finds_light", true));
    set_solid_light(program, shot, matrix);
    gl::draw_screen();
    solid_light.end();
    glViewport(0, 0, width, height);
    glEnable(GL_SCISSOR_TEST);
}

void Renderer::Device::bind_faces(gl::Program& program) const {
    program.texture("face_colour", 1, GL_TEXTURE_2D, face_colour.id());
    program.texture("face_normals", 2, GL_TEXTURE_2D, face_normals.id());
    program.texture("face_distance", 3, GL_TEXTURE_2D, face_distance.id());
}

/// Sets the uniforms for shading solids, with the light that the fluid and other solids hide from them.
void Renderer::Device::set_solid_light(gl::Program& program, const Shot& shot, const Eigen::Matrix4f& matrix) const {
    set_studio(program, shot);
    ground_light.bind_shadow(program, shadow_unit);
    field.bind(program, field_unit);
    solid_field.bind(program, solid_unit);
    program.set("fluid_hides", shot.hides);
    program.set("to_world", Eigen::Matrix4f(matrix.inverse()));
    bind_faces(program);
}

/// Draws distance, normals and materials of the solids that a sample shows, and marks their pixels in the stencil. The driver runs a shader
/// on whole blocks of pixels for each triangle, however small, so the expensive light comes in a later pass, once per pixel. Patterns are
/// expensive too: a pass of depth alone precedes them.
void Renderer::Device::draw_faces(const Shot& shot, const Eigen::Matrix4f& matrix) {
    if (!scene.any_solids()) return;
    glBindFramebuffer(GL_FRAMEBUFFER, faces.id());
    glDisable(GL_SCISSOR_TEST);
    const std::array<float, 4> none{};
    glClearBufferfv(GL_COLOR, 2, none.data());
    glEnable(GL_SCISSOR_TEST);
    const float lowest = shot.lowest() - 1e-4f;  // 0.1 mm lower, so that rounding does not fray objects on the ground
    if (shot.patterns != std::set{Pattern::plain}) {
        glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
        solid_depth.use();
        solid_depth.set("view_projection", matrix);
        begin_geometry(solid_depth, 0, lowest);
        scene.draw_solids(solid_depth, false, [](const FrameSolid&) {});
        glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    }
    glDepthFunc(GL_LEQUAL);
    for (const Pattern pattern : shot.patterns) {
        gl::Program& program = solid_faces.with(shot.constants + gl::constant("pattern", static_cast<int>(pattern)));
        set_studio(program, shot);
        program.set("view_projection", matrix);
        begin_geometry(program, solid_seen, lowest);
        const auto prepare = [&](const FrameSolid& s) {
            const SolidMaterial material = solid_material(s.appearance);
            program.set("solid_colour", material.colour);
            program.set("metal", material.metal);
            program.set("roughness", material.roughness);
            if (pattern == Pattern::picture) {
                pictures.bind(program, 0, s);
                program.set("picture_placed", scene.has_places(s) ? 1 : 0);
            }
        };
        scene.draw_solids(program, false, prepare, [&](const FrameSolid& s) { return solid_material(s.appearance).pattern == pattern; });
    }
    end_geometry();
    glDepthFunc(GL_LESS);
}

void Renderer::Device::shade_solids(const Shot& shot, const Eigen::Matrix4f& matrix, GLuint target) {
    glBindFramebuffer(GL_FRAMEBUFFER, target);
    if (!scene.any_solids()) return;
    glDisable(GL_DEPTH_TEST);
    shade_where(GL_EQUAL, solid_seen);
    gl::Program& program = solid_colour.with(shot.constants + gl::constant("finds_light", !shot.keeps_solid_light()));
    set_solid_light(program, shot, matrix);
    solid_light.bind(program, solid_light_unit);
    bind_patches(program, shot.patches);
    gl::draw_screen();
    glDisable(GL_STENCIL_TEST);
    glEnable(GL_DEPTH_TEST);
}

}  // namespace whorl
