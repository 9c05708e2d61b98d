#include "render/gl/renderer.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "render/flow/slice.h"
#include "render/gl/aov_pass.h"
#include "render/gl/context.h"
#include "render/gl/field_texture.h"
#include "render/gl/flow_shapes.h"
#include "render/gl/foam_pass.h"
#include "render/gl/glass_pass.h"
#include "render/gl/ground_light.h"
#include "render/gl/motion_blur.h"
#include "render/gl/objects.h"
#include "render/gl/sample_accumulator.h"
#include "render/gl/scene_geometry.h"
#include "render/gl/scene_lighting.h"
#include "render/gl/setup.h"
#include "render/gl/solid_field.h"
#include "render/gl/solid_pictures.h"
#include "render/look/environment.h"
#include "render/look/field_values.h"
#include "render/look/material.h"
#include "render/look/overlay.h"

namespace whorl {
namespace {

/// Texture units that passes share. Each pass uses units 0 .. 3 for its own textures.
constexpr int ground_unit = 4, shadow_unit = 5, field_unit = 7, solid_unit = 9, solid_light_unit = 10, ink_unit = 12, surround_unit = 13;

/// Least number of samples per pixel whose moments are close enough together to show motion. With fewer samples, and without an aperture,
/// the image is blurred along the motion (blur_motion()).
constexpr int samples_of_motion = 32;

/// Everything that an image is drawn from, except geometry.
struct Shot {
    const LookOptions& look;
    View view;
    Material material;
    float hides = 1;    ///< fraction of the surrounding light that the fluid keeps from objects inside it
    float spacing = 0;  ///< m
    float ground = 0;   ///< m
    Eigen::Matrix4f camera;
    Mat3f to_ray;  ///< position in the image (-1 .. 1, -1 .. 1, 1) -> direction
    float aspect = 1;
    bool blurred = false;    ///< the sum of the samples is blurred along the motion
    bool has_age = false;    ///< the fluid's surface has ages
    bool has_crust = false;  ///< the fluid's surface has plates of crust
    std::vector<EmissivePatch> patches;
    std::set<Pattern> patterns;  ///< textures of the solids
    std::string constants;       ///< GLSL constants of all programs

    /// Whether every pixel needs all samples. Otherwise a pixel that differs little from its neighbours keeps its first sample. The relief
    /// of a crust is found from neighbouring pixels, which later samples would lack.
    bool needs_all_samples() const { return look.samples < 2 || view.blurs() || shows_field(look) || has_crust; }
    /// Height below which nothing is drawn [m].
    float lowest() const { return look.ground ? ground : -1e6f; }
    /// Whether all samples share the solids' light of the first one: they see the solids at the same moment and from about the same
    /// position.
    bool keeps_solid_light() const { return view.open <= 0; }
    bool camera_moves() const { return !(view.position_velocity.isZero(0) && view.target_velocity.isZero(0)); }
    /// Whether the samples look up the background in the backdrop, which shows it from the frame's position. Only the lens moves them.
    bool samples_backdrop() const { return view.aperture > 0 && !(view.open > 0 && camera_moves()) && !is_transparent(look); }
    /// Whether the motion of the camera blurs the background, which the samples do not show.
    bool blurs_background() const { return blurred && !is_transparent(look) && camera_moves(); }
    /// Whether the surface's displacement is stored per pixel: the surface moves while the shutter is open, its distance field does not.
    bool keeps_motion() const { return view.open > 0 && material.refracts; }
};

/// Colour of the fluid drawn as an opaque body.
Vec3f body_colour(const Material& material) { return material.refracts ? material.scatter : material.colour; }

void set_scattering(gl::Program& program, const Material& material, float voxel) {
    program.set("free_path", material.scattering / voxel);
    program.set("sideways", Vec3f(sideways_reach(material) / voxel));
    program.set("fading", Vec3f(diffuse_attenuation(material) * voxel));
}

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

/// Stencil values of pixels that show a solid, and of pixels that show the fluid.
constexpr GLint solid_seen = 1, fluid_seen = 2;

/// Prepares for drawing solids or the fluid down to the height `lowest` [m]; drawn pixels get the stencil value `seen`.
void begin_geometry(gl::Program& program, GLint seen, float lowest) {
    program.set("cuts", 1);
    program.set("lowest", lowest);
    glEnable(GL_CLIP_DISTANCE0);
    glEnable(GL_STENCIL_TEST);
    glStencilFunc(GL_ALWAYS, seen, 0xff);
    glStencilOp(GL_KEEP, GL_KEEP, GL_REPLACE);
}

void end_geometry() {
    glDisable(GL_CLIP_DISTANCE0);
    glDisable(GL_STENCIL_TEST);
}

/// Limits drawing to pixels whose stencil value passes the comparison with `seen`; other pixels cost the software driver nothing.
void shade_where(GLenum comparison, GLint seen) {
    glEnable(GL_STENCIL_TEST);
    glStencilFunc(comparison, seen, 0xff);
    glStencilOp(GL_KEEP, GL_KEEP, GL_KEEP);
}

}  // namespace

struct Renderer::Device {
    Device(int w, int h) : width(w), height(h) { glEnable(GL_PROGRAM_POINT_SIZE); }
    ~Device() { context.make_current(); }  // deleting objects acts on the current context

    Image draw(const Frame& frame, const Surface& surface, const LookOptions& look, const View& view);
    PictureLayers draw_layers(const Frame& frame, const Surface& surface, const LookOptions& look, const View& view, const NextView& next);
    std::array<float, 2> begin(const Frame& frame, const LookOptions& look);
    Shot sum_samples(const Frame& frame, const Surface& surface, const LookOptions& look, const View& view,
                     const std::array<float, 2>& range, const PictureBox& box);
    bool refracts(const Material& material) const { return material.refracts && !field.empty(); }
    LayerView layer_view(const Shot& shot, const NextView& next) const;
    void blur_motion(const Shot& shot, float open);
    void draw_foam(const Shot& shot, const Frame& frame, float open);
    void draw_sample(const Shot& shot, int sample);
    void draw_from(const Shot& shot, int sample);
    void draw_faces(const Shot& shot, const Eigen::Matrix4f& matrix);
    void find_solid_light(const Shot& shot, const Eigen::Matrix4f& matrix);
    void shade_solids(const Shot& shot, const Eigen::Matrix4f& matrix, GLuint target);
    void draw_fluid(const Shot& shot, const Eigen::Matrix4f& matrix);
    void shade_sample(const Shot& shot, const Eigen::Matrix4f& matrix, float weight);
    void shade_fluid(const Shot& shot, const Eigen::Matrix4f& matrix, float weight);
    void draw_glass(const Shot& shot, const Eigen::Matrix4f& matrix, float weight);
    void set_body(gl::Program& program, const Material& material) const;
    void draw_refracted(const Shot& shot, const std::vector<FrameSolid>& solids);
    void draw_backdrop(const Shot& shot);
    enum class Light { shown, linear, behind_glass };
    void compose(const Shot& shot, GLuint target, Light light);
    PictureLayers light_of(const Shot& shot);
    Image read_back() const;
    void set_studio(gl::Program& program, const Shot& shot) const;
    void set_solid_light(gl::Program& program, const Shot& shot, const Eigen::Matrix4f& matrix) const;
    void bind_faces(gl::Program& program) const;

    GlContext context;  // declared first, so that all objects below are deleted while it is current
    int width, height;

    gl::Program fluid_normal{{"mesh.vert"}, {"octahedral.glsl", "normal.frag"}};
    gl::Program solid_depth{{"mesh.vert"}, {"depth.frag"}};
    gl::Programs solid_faces{{"mesh.vert"}, {"studio.glsl", "textures.glsl", "octahedral.glsl", "face.frag"}};
    gl::Programs solid_colour{{"screen.vert"},
                              {"studio.glsl", "textures.glsl", "table.glsl", "field.glsl", "solids.glsl", "shadow.glsl", "solid_light.glsl",
                               "hot.glsl", "octahedral.glsl", "faces.glsl", "solid.frag"}};
    gl::Programs solid_light_program{{"screen.vert"},
                                     {"studio.glsl", "textures.glsl", "table.glsl", "field.glsl", "solids.glsl", "shadow.glsl",
                                      "solid_light.glsl", "octahedral.glsl", "faces.glsl", "solid_light.frag"}};
    gl::Programs liquid{{"screen.vert"},
                        {"studio.glsl", "textures.glsl", "table.glsl", "field.glsl", "solids.glsl", "inks.glsl", "body.glsl",
                         "octahedral.glsl", "liquid.frag"}};
    gl::Programs opaque{{"screen.vert"},
                        {"studio.glsl", "textures.glsl", "table.glsl", "field.glsl", "solids.glsl", "inks.glsl", "crust.glsl",
                         "octahedral.glsl", "opaque.frag"}};
    gl::Programs glass_walls{{"mesh.vert"}, {"studio.glsl", "textures.glsl", "table.glsl", "glass.frag"}};
    gl::Programs glass_edges{{"edge.vert"}, {"studio.glsl", "textures.glsl", "table.glsl", "edge.frag"}};
    gl::Programs behind{{"screen.vert"}, {"studio.glsl", "textures.glsl", "table.glsl", "behind.frag"}};
    gl::Programs composing{{"screen.vert"}, {"studio.glsl", "textures.glsl", "table.glsl", "compose.frag"}};

    gl::Texture depth = gl::texture_2d(GL_DEPTH24_STENCIL8, width, height, false);
    gl::Texture solid = gl::texture_2d(GL_RGBA16F, width, height, false);
    gl::Texture normal = gl::texture_2d(GL_RGBA32F, width, height, false);
    gl::Texture glass = gl::texture_2d(GL_RGBA16F, width, height, false);
    gl::Texture picture = gl::texture_2d(GL_RGBA8, width, height, false);
    gl::Texture face_colour = gl::texture_2d(GL_RGBA16F, width, height, false);
    gl::Texture face_normals = gl::texture_2d(GL_RGBA16F, width, height, false);
    gl::Texture face_distance = gl::texture_2d(GL_R32F, width, height, false);
    gl::Framebuffer faces = gl::framebuffer({face_colour.id(), face_normals.id(), face_distance.id()}, depth.id());
    gl::Framebuffer geometry = gl::framebuffer({solid.id(), normal.id()}, depth.id());
    gl::Texture crust;  // or displacement of the surface; created for the first fluid that needs it
    gl::Framebuffer crusted_geometry;
    gl::Framebuffer glass_target = gl::framebuffer({glass.id()}, depth.id());
    gl::Framebuffer output = gl::framebuffer({picture.id()}, 0);
    std::optional<AovPass> aov_pass;  // created at first use
    std::optional<MotionBlur> motion_blur;
    std::optional<FoamPass> foam_pass;
    std::optional<GlassPass> glass_pass;

    SampleAccumulator samples{width, height, depth};
    Backdrop backdrop{width, height};
    SceneGeometry scene;
    FieldTexture field;
    SolidField solid_field{height};
    SolidPictures pictures;
    SolidLight solid_light{width, height};
    FlowShapes flow;
    InkField inks;
    GroundLight ground_light{height};
    SceneLighting lighting;
};

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
    const float ground = shot.look.ground ? shot.ground : -1e6f;
    return {shot.camera,
            camera_matrix(next.view, shot.aspect, scene.bounds()),
            shot.view.position,
            (shot.view.target - shot.view.position).normalized(),
            next.interval,
            ground,
            is_transparent(shot.look) ? -1e6f : ground,
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

void Renderer::Device::draw_backdrop(const Shot& shot) {
    if (!is_transparent(shot.look)) {
        const Backdrop::Key key{shot.to_ray,
                                studio_axes(shot.view),
                                shot.view.position,
                                shot.view.fov,
                                shot.look.background,
                                shot.look.table,
                                shot.look.environment.string(),
                                {shot.look.surround_strength, shot.look.surround_turn},
                                shot.look.lights,
                                shot.look.ground ? shot.ground : -1e6f,
                                shot.look.table == "none" && shot.look.lights.empty() ? Vec3f::UnitZ() : shot.view.target};
        backdrop.draw(key, shot.constants, [&](gl::Program& program) { set_studio(program, shot); });
    }
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
