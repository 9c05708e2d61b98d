#include "render/gl/foam_pass.h"

#include <cmath>
#include <numbers>

namespace whorl {

void FoamPass::fill(const Frame& frame, float amount) {
    const std::vector<FoamPoint> points = foam_points(frame, amount);
    std::vector<Vec3f> position, velocity;
    std::vector<float> form, spray;
    std::vector<std::uint32_t> index;
    position.reserve(4 * points.size()), velocity.reserve(4 * points.size()), form.reserve(16 * points.size()),
        index.reserve(6 * points.size());
    for (const FoamPoint& p : points) {
        const auto first = static_cast<std::uint32_t>(position.size());
        for (const float across : {-1.0f, 1.0f})
            for (const float along : {-1.0f, 1.0f}) {
                position.push_back(p.position), velocity.push_back(p.velocity);
                form.insert(form.end(), {along, across, p.radius, p.mist ? -p.opacity : p.opacity}), spray.push_back(p.spray ? 1 : 0);
            }
        for (const std::uint32_t corner : {0, 1, 2, 2, 1, 3}) index.push_back(first + corner);
    }
    corners_.fill({gl::numbers(position), gl::numbers(velocity), {form.data(), form.size()}, {spray.data(), spray.size()}}, index.data(),
                  index.size());
}

void FoamPass::draw(GLuint picture, const FoamView& foam, const std::string& constants, const std::function<void(gl::Program&)>& prepare) {
    if (corners_.count() == 0) return;
    if (picture != picture_) target_ = gl::framebuffer({picture}, 0), picture_ = picture;
    gl::draw_into(target_, width_, height_);
    gl::Program& program = program_.with(constants);
    prepare(program);
    program.texture("normal_buffer", 1, GL_TEXTURE_2D, foam.normals);
    program.texture("solid_buffer", 2, GL_TEXTURE_2D, foam.solids);
    program.set("view_projection", foam.matrix);
    program.set("half_size", Eigen::Vector2f(0.5f * static_cast<float>(width_), 0.5f * static_cast<float>(height_)));
    program.set("pixels", 0.5f * static_cast<float>(height_) / std::tan(foam.view.fov * std::numbers::pi_v<float> / 360));
    program.set("open", foam.open);
    program.set("lens", Eigen::Vector2f(0.5f * foam.view.aperture, foam.view.focus));
    program.set("spacing", foam.spacing);
    program.set("lamp", foam.lamp);
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    corners_.draw(GL_TRIANGLES);
    glDisable(GL_BLEND);
}

}  // namespace whorl
