#include "render/gl/backdrop.h"

namespace whorl {

Backdrop::Backdrop(int width, int height)
    : width_(width), height_(height), paper_(gl::texture_2d(GL_RGBA16F, width, height, false)), target_(gl::framebuffer({paper_.id()}, 0)) {
}

void Backdrop::draw(const Key& key, const std::string& constants, const std::function<void(gl::Program&)>& prepare, GLuint no_vertices) {
    if (key_ == key) return;
    key_ = key;
    gl::Program& program = program_.with(constants);
    prepare(program);
    program.set("to_ray", key.to_ray);
    glBindFramebuffer(GL_FRAMEBUFFER, target_.id());
    glViewport(0, 0, width_, height_);
    glBindVertexArray(no_vertices);
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

void Backdrop::bind(gl::Program& program, int unit) const {
    program.texture("paper", unit, GL_TEXTURE_2D, paper_.id());
    // Of a direction r the ground's place is eye + r (ground - eye.y)/r.y.
    Mat3f to_ground;
    const Mat3f& ray = key_->to_ray;
    for (const int row : {0, 1}) to_ground.row(row) = key_->eye[2 * row] * ray.row(1) + (key_->ground - key_->eye.y()) * ray.row(2 * row);
    to_ground.row(2) = ray.row(1);
    program.set("to_ground", to_ground);
}

}  // namespace whorl
