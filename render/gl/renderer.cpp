#include "render/gl/renderer.h"

#include <algorithm>
#include <cmath>

#include "render/flow/slice.h"
#include "render/gl/renderer_device.h"
#include "render/look/environment.h"
#include "render/look/field_values.h"
#include "render/look/overlay.h"

namespace whorl {
namespace {

/// Least number of samples per pixel whose moments are close enough together to show motion. With fewer samples, and without an aperture,
/// the image is blurred along the motion (blur_motion()).
constexpr int samples_of_motion = 32;

/// Matrix from the whole image to a box of it, both in coordinates -1 .. 1. The backdrop continues around the box.
Eigen::Matrix3f into_box(const PictureBox& box, int width, int height) {
    const float w = static_cast<float>(width), h = static_cast<float>(height);
    Eigen::Matrix3f into = Eigen::Matrix3f::Identity();
    into(0, 0) = static_cast<float>(box.width) / w, into(1, 1) = static_cast<float>(box.height) / h;
    into(0, 2) = (2 * static_cast<float>(box.x) + static_cast<float>(box.width)) / w - 1;
    into(1, 2) = 1 - (2 * static_cast<float>(box.y) + static_cast<float>(box.height)) / h;
    return into;
}

/// into_box() for clip coordinates.
Eigen::Matrix4f clip_into(const Eigen::Matrix3f& into) {
    Eigen::Matrix4f clip = Eigen::Matrix4f::Identity();
    clip.topLeftCorner<2, 2>() = into.topLeftCorner<2, 2>();
    clip.topRightCorner<2, 1>() = into.topRightCorner<2, 1>();
    return clip;
}

}  // namespace

void Renderer::Device::set_studio(gl::Program& program, const Shot& shot) const {
    program.use();
    lighting.bind(program, shot.look, shot.view, shot.ground, height, surround_unit);
    ground_light.bind_ground(program, ground_unit);
}

/// Prepares the context and the lighting. @return range of the colour map
std::array<float, 2> Renderer::Device::begin(const Frame& frame, const LookOptions& look) {
    context.make_current();
    lighting.fill(look);
    return shows_field(look) ? field_range(field_values(frame, look), look) : std::array<float, 2>{0, 1};
}

Image Renderer::Device::draw(const Frame& frame, const Surface& surface, const LookOptions& look, const View& view) {
    const std::array<float, 2> range = begin(frame, look);
    if (look.style == "slice" && view.flat) return draw_slice_image(frame, look, range, {width, height}, view.box);
    const Layout layout = layout_of(width, height, static_cast<float>(width) / static_cast<float>(height), look, range);
    const Shot shot = sum_samples(frame, surface, look, view, range, layout.flow);
    Image image;
    if (is_transparent(look)) image = shown(light_of(shot));
    else compose(shot, output.id(), Light::shown), image = read_back();
    if (shows_field(look)) draw_words(image, layout, look, range, frame.time);
    else draw_words_over(image, look, frame.time);
    return image;
}

PictureLayers Renderer::Device::draw_layers(const Frame& frame, const Surface& surface, const LookOptions& look, const View& view,
                                            const NextView& next) {
    const Shot shot = sum_samples(frame, surface, look, view, begin(frame, look), {0, 0, width, height});
    PictureLayers layers = light_of(shot);
    if (shows_field(look)) return layers;
    scene.go_to(0);
    aov_pass->add_places(layers, scene, layer_view(shot, next));
    return layers;
}

LayerView Renderer::Device::layer_view(const Shot& shot, const NextView& next) const {
    return {shot.camera,
            camera_matrix(next.view, shot.aspect, scene.bounds()),
            shot.view.position,
            (shot.view.target - shot.view.position).normalized(),
            next.interval,
            shot.lowest(),
            is_transparent(shot.look) ? -1e6f : shot.lowest(),
            0.5f * shot.spacing,
            !shot.look.environment.empty()};
}

/// Blurs the sum of the samples, which all show the frame's time, along the motion while the shutter is open. @param open s
void Renderer::Device::blur_motion(const Shot& shot, float open) {
    NextView next{shot.view, open};
    next.view.position += open * next.view.position_velocity, next.view.target += open * next.view.target_velocity;
    if (!aov_pass) aov_pass.emplace(width, height, depth);
    if (!motion_blur) motion_blur.emplace(width, height);
    scene.go_to(0);
    aov_pass->draw_places(scene, layer_view(shot, next));
    motion_blur->blur(samples.sum(), aov_pass->motion_and_depth());
}

/// Draws all samples of an image and adds them up. @param box part of the image that shows the flow
Shot Renderer::Device::sum_samples(const Frame& frame, const Surface& surface, const LookOptions& look, const View& view,
                                   const std::array<float, 2>& range, const PictureBox& box) {
    if (shows_field(look)) flow.fill(scene, frame, look, view, range, std::max(width, height));
    else scene.fill(frame, surface);
    field.fill(shows_field(look) ? Volume{} : surface.distance);
    solid_field.fill(frame.solids);
    pictures.fill(frame.solids);
    const float size = (frame.domain_max - frame.domain_min).norm();
    Material material = fluid_material(look, size);
    if (surface.glows_by_temperature && material.cooling > 0) material.cooling = 1;
    const Vec3f body = body_colour(material);
    inks.fill(frame, look, size, !shows_field(look), refracts(material) ? nullptr : &body);
    const float aspect = static_cast<float>(width) / static_cast<float>(height);
    const Eigen::Matrix4f camera = camera_matrix(view, aspect, scene.bounds());
    const Mat3f into = into_box(shows_field(look) ? box : PictureBox{0, 0, width, height}, width, height);
    View seen = view;
    if (look.samples < 2) seen.aperture = 0;  // a single sample shows no blur, and costs less without
    if (look.samples < samples_of_motion && seen.aperture <= 0) seen.open = 0;
    Shot shot{look,
              seen,
              material,
              hides(material, size),
              frame.spacing,
              ground_height(frame),
              clip_into(into) * camera,
              rays(view, aspect) * into.inverse(),
              aspect,
              seen.open < view.open && !shows_field(look),
              !surface.age.empty(),
              !surface.crust.nearest.empty() && !shows_field(look),
              {},
              {},
              lighting.constants(look) + gl::constant("draws_behind", seen.blurs()) + gl::constant("transparent", is_transparent(look))};
    for (const FrameSolid& s : frame.solids) shot.patterns.insert(solid_material(s.appearance).pattern);
    if (!shows_field(look)) shot.patches = hot_patches(surface, shot.material);
    scene.go_to(0);
    ground_light.draw(scene, shot.material, lighting.lamps(look, view), frame.spacing,
                      look.ground ? std::optional(shot.ground) : std::nullopt, lighting.constants(look));

    draw_backdrop(shot);
    glViewport(0, 0, width, height);
    samples.begin(look.samples, shot.needs_all_samples());
    if (scene.any_containers() || scene.any_glass()) {
        glBindFramebuffer(GL_FRAMEBUFFER, glass_target.id());
        glClear(GL_COLOR_BUFFER_BIT);
    }
    for (int i = 0; i < samples.count(); ++i) draw_sample(shot, i);
    if (shot.blurred) blur_motion(shot, view.open);
    if (look.foam > 0 && !shows_field(look)) draw_foam(shot, frame, view.open);
    if (scene.any_glass()) draw_refracted(shot, frame.solids);
    return shot;
}

/// After all samples and their blur: points have their own streaks.
void Renderer::Device::draw_foam(const Shot& shot, const Frame& frame, float open) {
    if (!foam_pass) foam_pass.emplace(width, height);
    foam_pass->fill(frame, shot.look.foam);
    foam_pass->draw(samples.sum(),
                    {shot.view, shot.camera, shot.spacing, open, lighting.shadow_lamp(shot.look, shot.view), normal.id(), solid.id()},
                    shot.constants, [&](gl::Program& program) {
                        set_studio(program, shot);
                        field.bind(program, field_unit);
                    });
}

/// Draws one sample. Each sample has its own position in the pixel, position on the lens, and moment while the shutter is open.
void Renderer::Device::draw_sample(const Shot& shot, int sample) {
    const float turn = 0.618034f * static_cast<float>(sample) + 0.5f, moment = (turn - std::floor(turn) - 0.5f) * shot.view.open;
    scene.go_to(moment);
    if (!shot.view.blurs()) return draw_from(shot, sample);
    Shot from = shot;
    View& view = from.view;
    view.position += moment * view.position_velocity, view.target += moment * view.target_velocity;
    if (!shows_field(shot.look)) from.camera = camera_matrix(view, shot.aspect, scene.bounds());
    const Vec3f right = studio_axes(view).row(0), up = right.cross(view.target - view.position).normalized();
    const Eigen::Vector2f place = 0.5f * view.aperture * lens_place(sample, samples.count());
    const Vec3f aside = place.x() * right + place.y() * up;
    if (view.aperture > 0) from.camera = through_lens(from.camera, view, aside);
    view.position += aside, view.target += aside;
    draw_from(from, sample);
}

void Renderer::Device::draw_from(const Shot& shot, int sample) {
    const Eigen::Matrix4f matrix = jittered(shot.camera, sample_place(sample, samples.count()), width, height);
    const PixelBox box = shot.view.blurs() ? PixelBox{0, 0, width, height} : pixels_of(scene.bounds(), shot.camera, width, height);
    glEnable(GL_SCISSOR_TEST);
    glScissor(box.x, box.y, box.width, box.height);

    const bool keeps_more = shot.has_crust || shot.keeps_motion();
    if (keeps_more && crust.id() == 0) {
        crust = gl::texture_2d(GL_RGBA32F, width, height, false);
        crusted_geometry = gl::framebuffer({solid.id(), normal.id(), crust.id()}, depth.id());
    }
    const gl::Framebuffer& things = keeps_more ? crusted_geometry : geometry;
    const auto draw_front = [&] {
        if (shows_field(shot.look))
            flow.draw(scene, {shot.look, shot.view, shot.spacing, width, height, [&](gl::Program& program) { set_studio(program, shot); }},
                      matrix);
        else draw_fluid(shot, matrix);
    };
    glEnable(GL_DEPTH_TEST);
    if (!samples.leaves_out(sample)) {
        glBindFramebuffer(GL_FRAMEBUFFER, things.id());
        glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
        draw_faces(shot, matrix);
        if (sample == 0 && shot.keeps_solid_light()) find_solid_light(shot, matrix);
        shade_solids(shot, matrix, things.id());
        draw_front();
    } else {
        samples.mask_converged(depth);
        if (sample == 1 && scene.any_containers()) samples.complete_glass(glass_target);
        draw_faces(shot, matrix);
        glBindFramebuffer(GL_FRAMEBUFFER, things.id());
        draw_front();
        // Shaded after the fluid: solids that it hides, which only refraction shows, keep the light of the first sample.
        shade_solids(shot, matrix, things.id());
        samples.clear_background();
    }
    glDisable(GL_DEPTH_TEST);

    glBindFramebuffer(GL_FRAMEBUFFER, samples.target(sample));
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ONE);
    if (shot.look.style == "volume") flow.shade_cloud(shot.look, shot.view, solid, matrix, sample);
    else shade_sample(shot, matrix, samples.weight(sample));
    if (scene.any_containers()) draw_glass(shot, matrix, samples.weight());
    glDisable(GL_BLEND);
    if (samples.may_converge(sample)) samples.mark_converged(scene.any_containers() ? glass.id() : 0);
    glDisable(GL_SCISSOR_TEST);
}

Renderer::Renderer(int width, int height) : device_(std::make_unique<Device>(width, height)) {}
Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
std::string Renderer::device() const { return device_->context.device(); }
Image Renderer::draw(const Frame& frame, const Surface& surface, const LookOptions& look, const View& view) {
    return device_->draw(frame, surface, look, view);
}
PictureLayers Renderer::draw_layers(const Frame& frame, const Surface& surface, const LookOptions& look, const View& view,
                                    const NextView& next) {
    return device_->draw_layers(frame, surface, look, view, next);
}

}  // namespace whorl
