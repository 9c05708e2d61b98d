#include "render/gl/aov_pass.h"

#include <Eigen/LU>
#include <cmath>

namespace whorl {
namespace {

/// Values first .. first + count - 1 of each group of four.
std::vector<float> some_of(const std::vector<float>& fours, std::size_t first, std::size_t count) {
    std::vector<float> values;
    values.reserve(fours.size() / 4 * count);
    for (std::size_t i = first; i < fours.size(); i += 4)
        values.insert(values.end(), fours.begin() + static_cast<std::ptrdiff_t>(i), fours.begin() + static_cast<std::ptrdiff_t>(i + count));
    return values;
}

}  // namespace

AovPass::AovPass(int width, int height, const gl::Texture& depth)
    : width_(width), height_(height), light_(gl::texture_2d(GL_RGBA16F, width, height, false)),
      shadow_(gl::texture_2d(GL_RGBA16F, width, height, false)), normal_and_number_(gl::texture_2d(GL_RGBA32F, width, height, false)),
      motion_and_depth_(gl::texture_2d(GL_RGBA32F, width, height, false)), light_target_(gl::framebuffer({light_.id(), shadow_.id()}, 0)),
      place_target_(gl::framebuffer({normal_and_number_.id(), motion_and_depth_.id()}, depth.id())) {}

std::vector<float> AovPass::read(GLenum attachment) const {
    std::vector<float> upside_down(4 * grid_count(width_, height_)), rows(upside_down.size());
    glReadBuffer(attachment);
    glReadPixels(0, 0, width_, height_, GL_RGBA, GL_FLOAT, upside_down.data());
    const std::size_t row = 4 * static_cast<std::size_t>(width_);
    for (int y = 0; y < height_; ++y)
        std::copy_n(upside_down.begin() + static_cast<std::ptrdiff_t>(row * static_cast<std::size_t>(height_ - 1 - y)), row,
                    rows.begin() + static_cast<std::ptrdiff_t>(row * static_cast<std::size_t>(y)));
    return rows;
}

PictureLayers AovPass::read_light(bool has_shadow) const {
    PictureLayers layers{width_, height_};
    glBindFramebuffer(GL_FRAMEBUFFER, light_target_.id());
    layers.light = read(GL_COLOR_ATTACHMENT0);
    if (has_shadow) layers.shadow = some_of(read(GL_COLOR_ATTACHMENT1), 0, 3);
    return layers;
}

void AovPass::draw_places(const SceneGeometry& scene, const LayerView& view) {
    gl::draw_into(place_target_, width_, height_);
    glClear(GL_DEPTH_BUFFER_BIT);
    const Eigen::Vector2f half_size = 0.5f * Eigen::Vector2f(static_cast<float>(width_), static_cast<float>(height_));
    behind_.use();
    behind_.set("to_world", Eigen::Matrix4f(view.now.inverse()));
    behind_.set("next_view_projection", view.next);
    behind_.set("eye", view.eye);
    behind_.set("forward", view.forward);
    behind_.set("ground_height", view.seen_ground);
    behind_.set("nothing_there", nothing_there);
    behind_.set("turns", view.turns ? 1 : 0);
    behind_.set("half_size", half_size);
    gl::draw_screen();

    glEnable(GL_DEPTH_TEST);
    things_.use();
    things_.set("view_projection", view.now);
    things_.set("next_view_projection", view.next);
    things_.set("interval", view.interval);
    things_.set("eye", view.eye);
    things_.set("forward", view.forward);
    things_.set("ground_height", view.ground);
    things_.set("half_size", half_size);
    scene.draw_numbered(things_, view.interval, view.tolerance);
    glDisable(GL_DEPTH_TEST);
}

void AovPass::add_places(PictureLayers& layers, const SceneGeometry& scene, const LayerView& view) {
    draw_places(scene, view);
    const std::vector<float> normal_and_number = read(GL_COLOR_ATTACHMENT0), motion_and_depth = read(GL_COLOR_ATTACHMENT1);
    layers.normal = some_of(normal_and_number, 0, 3);
    layers.motion = some_of(motion_and_depth, 0, 2);
    layers.depth = some_of(motion_and_depth, 2, 1);
    layers.id.reserve(layers.depth.size());
    for (std::size_t i = 3; i < normal_and_number.size(); i += 4)
        layers.id.push_back(static_cast<std::uint32_t>(std::lround(normal_and_number[i])));
}

}  // namespace whorl
