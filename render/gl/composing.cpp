// The finished image: backdrop, sum of the samples and glass, as an image for screens or as linear light.
#include <Eigen/LU>

#include "render/gl/renderer_device.h"

namespace whorl {

void Renderer::Device::draw_backdrop(const Shot& shot) {
    if (is_transparent(shot.look)) return;
    const Backdrop::Key key{shot.to_ray,
                            studio_axes(shot.view),
                            shot.view.position,
                            shot.view.fov,
                            shot.look.background,
                            shot.look.table,
                            shot.look.environment.string(),
                            {shot.look.surround_strength, shot.look.surround_turn},
                            shot.look.lights,
                            shot.lowest(),
                            shot.look.table == "none" && shot.look.lights.empty() ? Vec3f::UnitZ() : shot.view.target};
    backdrop.draw(key, shot.constants, [&](gl::Program& program) { set_studio(program, shot); });
}

/// @param light an image for screens; linear light and the shadow, for compositors; or the linear light that glass shows
void Renderer::Device::compose(const Shot& shot, GLuint target, Light light) {
    const bool linear = light == Light::linear, plain = light == Light::behind_glass;
    glBindFramebuffer(GL_FRAMEBUFFER, target);
    // Rows above the part of the ground that has a light map need no look-up.
    Bounds area;
    const Vec3f middle = ground_light.area(), corner(middle.z(), 0, middle.z());
    area.add(Vec3f(middle.x(), shot.ground, middle.y()) - corner), area.add(Vec3f(middle.x(), shot.ground, middle.y()) + corner);
    const PixelBox box = pixels_of(area, shot.camera, width, height);
    const int lit = linear ? height : box.y + box.height;
    const bool moves = shot.blurs_background();
    glEnable(GL_SCISSOR_TEST);
    for (const bool has_light : {true, false}) {
        glScissor(0, has_light ? 0 : lit, width, has_light ? lit : height - lit);
        gl::Program& program = composing.with(shot.constants + gl::constant("linear", linear) + gl::constant("plain", plain) +
                                              gl::constant("has_glass", !plain && (scene.any_containers() || scene.any_glass())) +
                                              gl::constant("has_light", has_light) + gl::constant("background_moves", moves));
        set_studio(program, shot);
        if (!is_transparent(shot.look)) backdrop.bind(program, 2);
        program.texture("samples", 0, GL_TEXTURE_2D, samples.sum());
        program.texture("glass", 1, GL_TEXTURE_2D, glass.id());
        if (moves) program.texture("motion", 3, GL_TEXTURE_2D, aov_pass->motion_and_depth());
        program.set("to_world", Eigen::Matrix4f(shot.camera.inverse()));
        program.set("exposure", shot.look.exposure);
        program.set("aspect", shot.aspect);
        gl::draw_screen();
    }
    glDisable(GL_SCISSOR_TEST);
}

PictureLayers Renderer::Device::light_of(const Shot& shot) {
    if (!aov_pass) aov_pass.emplace(width, height, depth);
    compose(shot, aov_pass->light_target().id(), Light::linear);
    return aov_pass->read_light(is_transparent(shot.look));
}

Image Renderer::Device::read_back() const {
    Image image = plain_image(width, height, 0);
    // The driver copies four bytes per pixel unchanged; it would convert pixels of three bytes one by one.
    std::vector<std::uint8_t> rows(4 * image.rgb.size() / 3);
    glReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, rows.data());
    for (int y = 0; y < height; ++y) {
        const std::uint8_t* from = rows.data() + 4 * grid_index(0, height - 1 - y, width);
        std::uint8_t* to = image.pixel(0, y);
        for (int x = 0; x < width; ++x, from += 4, to += 3) to[0] = from[0], to[1] = from[1], to[2] = from[2];
    }
    return image;
}

}  // namespace whorl
