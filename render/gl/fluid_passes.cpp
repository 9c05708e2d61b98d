// Passes of the fluid: its surface, and the light that leaves it.
#include <Eigen/LU>

#include "render/gl/renderer_device.h"

namespace whorl {
namespace {

void set_scattering(gl::Program& program, const Material& material, float voxel) {
    program.set("free_path", material.scattering / voxel);
    program.set("sideways", Vec3f(sideways_reach(material) / voxel));
    program.set("fading", Vec3f(diffuse_attenuation(material) * voxel));
}

}  // namespace

void Renderer::Device::draw_fluid(const Shot& shot, const Eigen::Matrix4f& matrix) {
    glColorMaski(0, GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    fluid_normal.use();
    fluid_normal.set("view_projection", matrix);
    fluid_normal.set("eye", shot.view.position);
    fluid_normal.set("keeps_motion", shot.keeps_motion() ? 1 : 0);
    glEnable(GL_CULL_FACE);
    begin_geometry(fluid_normal, fluid_seen, shot.lowest() - 0.5f * shot.spacing);
    scene.draw_fluid(fluid_normal);
    end_geometry();
    glDisable(GL_CULL_FACE);
    glColorMaski(0, GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
}

void Renderer::Device::shade_sample(const Shot& shot, const Eigen::Matrix4f& matrix, float weight) {
    // Pixels without fluid or solid have light only if each sample draws its own backdrop, or a flow, which the stencil does not mark.
    if (shot.view.blurs() || shows_field(shot.look)) shade_where(GL_NOTEQUAL, fluid_seen);
    else shade_where(GL_EQUAL, solid_seen);
    gl::Program& program = behind.with(shot.constants + gl::constant("samples_backdrop", shot.samples_backdrop()));
    set_studio(program, shot);
    if (shot.samples_backdrop()) backdrop.bind(program, 3);
    program.texture("solid_buffer", 2, GL_TEXTURE_2D, solid.id());
    program.set("to_world", Eigen::Matrix4f(matrix.inverse()));
    program.set("weight", weight);
    gl::draw_screen();
    shade_where(GL_EQUAL, fluid_seen);
    shade_fluid(shot, matrix, weight);
    glDisable(GL_STENCIL_TEST);
}

/// Sets the uniforms of the fluid's inside (body.glsl).
void Renderer::Device::set_body(gl::Program& program, const Material& material) const {
    inks.bind(program, ink_unit, field.voxel());
    program.set("roughness", material.roughness);
    program.set("refraction", material.refraction);
    program.set("absorption", Vec3f(material.absorption * field.voxel()));
    program.set("scatter", material.scatter);
    program.set("haze", material.haze * field.voxel());
    program.set("body_colour", body_colour(material));
}

void Renderer::Device::shade_fluid(const Shot& shot, const Eigen::Matrix4f& matrix, float weight) {
    const Material& material = shot.material;
    const bool crusted = shot.has_crust && material.cooling > 0 && !refracts(material);
    gl::Program& program =
        (refracts(material) ? liquid : opaque)
            .with(shot.constants + gl::constant("scatters", material.scattering > 0) + gl::constant("has_crust", crusted));
    set_studio(program, shot);
    if (material.scattering > 0) set_scattering(program, material, field.voxel());
    field.bind(program, field_unit);
    solid_field.bind(program, solid_unit);
    program.texture("normal_buffer", 1, GL_TEXTURE_2D, normal.id());
    program.texture("solid_buffer", 2, GL_TEXTURE_2D, solid.id());
    program.texture("crust_buffer", 3, GL_TEXTURE_2D, crust.id());
    program.texture("motion_buffer", 3, GL_TEXTURE_2D, crust.id());
    program.set("has_motion", shot.keeps_motion() ? 1 : 0);
    if (crusted) scene.bind_crust(program, 0);
    program.set("to_world", Eigen::Matrix4f(matrix.inverse()));
    program.set("to_clip", matrix);
    program.set("weight", weight);
    set_body(program, material);
    program.set("emission", material.emission);
    program.set("cooling", shot.has_age ? material.cooling : 0.0f);
    program.set("softness", material.refracts ? 0.5f : material.softness);
    gl::draw_screen();
}

}  // namespace whorl
