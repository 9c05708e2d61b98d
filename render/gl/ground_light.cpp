#include "render/gl/ground_light.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "render/gl/setup.h"

namespace whorl {
namespace {

/// Creates the mip levels of a texture: averages over squares of 2, 4, 8, ... texels.
void average(const gl::Texture& texture) {
    glBindTexture(GL_TEXTURE_2D, texture.id());
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
    glGenerateMipmap(GL_TEXTURE_2D);
}

/// Area of the ground with a light map: centre x, z, half-width [m]. It grows and moves in steps, so that its texels do not move while the
/// fluid flows.
Vec3f ground_area(const Bounds& bounds) {
    const float reach = 1.9f * bounds.radius();
    const float half = std::exp2(std::ceil(2 * std::log2(std::max(reach, 1e-6f))) / 2);
    const float step = half / 16;
    const Vec3f middle = bounds.centre();
    return {step * std::round(middle.x() / step), step * std::round(middle.z() / step), half};
}

}  // namespace

void GroundLight::draw(const SceneGeometry& scene, const Material& material, const LampLight& light, float spacing,
                       std::optional<float> ground, const std::string& constants) {
    light_ = light;
    centre_ = scene.bounds().centre();
    radius_ = std::max(1.02f * scene.bounds().radius(), 1e-4f);
    if (maps_ != light.lamps.size()) make_maps(light.lamps.size());
    light_matrices_.clear();
    glDisable(GL_DEPTH_TEST);
    const Vec3f absorption =
        material.refracts ? Vec3f(material.absorption + Vec3f::Constant(0.15f * material.haze)) : Vec3f::Constant(1e6f);
    for (std::size_t k = 0; k < light.lamps.size(); ++k) {
        const Lamp& lamp = light.lamps[k];
        light_matrices_.push_back(lamp.near ? lamp_matrix(lamp.place, scene.bounds()) : light_matrix(lamp.place, scene.bounds()));
        draw_layers(scene, k, spacing);
        gl::draw_into(transmission_target_, light_size, light_size);
        glViewport(static_cast<int>(k) * light_size, 0, light_size, light_size);
        transmission_program_.use();
        const float away = lamp.near ? (centre_ - lamp.place).norm() : 1;
        transmission_program_.set("map_width", 2 * away / light_matrices_[k].block<1, 3>(0, 0).norm());
        draw_transmission(material, absorption, scene.any_glass());
    }
    average(open_);
    average(blockers_);

    area_ = Vec3f(0, 0, 1e-9f);
    if (!ground) return;
    area_ = ground_area(scene.bounds());
    const float thick = scene.fluid_bounds().empty() ? 0.0f : 0.35f * scene.fluid_bounds().radius();
    const Vec3f tint = material.refracts ? Vec3f(0.55f * (-absorption * thick).array().exp()) : Vec3f(0.35f * material.colour);
    draw_ground(scene, tint, *ground, spacing, ground_program_.with(constants));
}

void GroundLight::make_maps(std::size_t lamps) {
    const int width = static_cast<int>(lamps) * light_size;
    open_ = gl::texture_2d(GL_RGBA16F, width, light_size, true);
    blockers_ = gl::texture_2d(GL_RGBA32F, width, light_size, true);
    transmission_target_ = gl::framebuffer({open_.id(), blockers_.id()}, 0);
    maps_ = lamps;
}

void GroundLight::draw_transmission(const Material& material, const Vec3f& absorption, bool has_glass) {
    transmission_program_.use();
    transmission_program_.texture("fluid_layers", 0, GL_TEXTURE_2D, fluid_layers_.id());
    transmission_program_.texture("solid_layers", 1, GL_TEXTURE_2D, solid_layers_.id());
    transmission_program_.texture("glass_layers", 2, GL_TEXTURE_2D, glass_layers_.id());
    transmission_program_.texture("glass_depth", 3, GL_TEXTURE_2D, glass_depth_.id());
    transmission_program_.set("has_glass", has_glass ? 1 : 0);
    transmission_program_.set("shadow_absorption", absorption);
    transmission_program_.set("haze", material.haze);
    transmission_program_.set("glow", material.refracts ? Vec3f(0.25f * material.scatter) : Vec3f::Zero().eval());
    transmission_program_.set("caustic", material.refracts ? 3.0f : 0.0f);
    gl::draw_screen();
}

void GroundLight::draw_layers(const SceneGeometry& scene, std::size_t k, float spacing) {
    const Lamp& lamp = light_.lamps[k];
    gl::draw_into(layers_target_, light_size, light_size);
    glClearColor(0, 0, 0, 0);
    glClear(GL_COLOR_BUFFER_BIT);
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ONE);
    layers_program_.use();
    layers_program_.set("view_projection", light_matrices_[k]);
    layers_program_.set("lamp", Eigen::Vector4f(lamp.place.x(), lamp.place.y(), lamp.place.z(), lamp.near ? 1 : 0));
    layers_program_.set("light_centre", centre_);
    layers_program_.set("is_solid", scene.are_particles() ? 1 : 0);
    layers_program_.set("point_size", 0.5f * spacing * static_cast<float>(light_size) / radius_);
    scene.draw_fluid(layers_program_);
    layers_program_.set("is_solid", 1);
    scene.draw_solids(layers_program_, false, [](const FrameSolid&) {});
    if (scene.any_glass()) draw_glass(scene);
    glDisable(GL_BLEND);
}

/// Adds up the layers of glass; the uniforms and the blending of draw_layers() are set.
void GroundLight::draw_glass(const SceneGeometry& scene) {
    if (glass_layers_.id() == 0) {
        glass_layers_ = gl::texture_2d(GL_RGBA32F, light_size, light_size, true);
        glass_depth_ = gl::texture_2d(GL_RGBA32F, light_size, light_size, true);
        glass_target_ = gl::framebuffer({glass_layers_.id(), glass_depth_.id()}, 0);
    }
    gl::draw_into(glass_target_, light_size, light_size);
    glClear(GL_COLOR_BUFFER_BIT);
    layers_program_.set("is_solid", 0);
    layers_program_.set("is_glass", 1);
    scene.draw_glass(layers_program_,
                     [&](const FrameSolid& solid) { layers_program_.set("absorption", solid_material(solid.appearance).absorption); });
    layers_program_.set("is_glass", 0);
}

void GroundLight::draw_ground(const SceneGeometry& scene, const Vec3f& tint, float ground, float spacing, gl::Program& program) {
    // View from above: x, z of the area -> clip.
    Eigen::Matrix4f from_above = Eigen::Matrix4f::Zero();
    from_above(0, 0) = from_above(1, 2) = 1 / area_.z();
    from_above(0, 3) = -area_.x() / area_.z();
    from_above(1, 3) = -area_.y() / area_.z();
    from_above(3, 3) = 1;
    gl::draw_into(lowest_target_, ground_size, ground_size);
    glClearColor(1e3f, 0, 0, 0);
    glClear(GL_COLOR_BUFFER_BIT);
    glEnable(GL_BLEND);
    glBlendEquation(GL_MIN);
    lowest_program_.use();
    lowest_program_.set("view_projection", from_above);
    lowest_program_.set("point_size", 0.5f * spacing * static_cast<float>(ground_size) / area_.z());
    scene.draw_fluid(lowest_program_);
    scene.draw_solids(lowest_program_, false, [](const FrameSolid&) {});
    scene.draw_glass(lowest_program_, [](const FrameSolid&) {});
    glBlendEquation(GL_FUNC_ADD);
    glDisable(GL_BLEND);

    const Eigen::Vector4f reach = 0.5f * area_.z() * Eigen::Vector4f(0.015f, 0.05f, 0.15f, 0.4f);  // m
    gl::draw_into(nearness_target_, ground_size, ground_size);
    nearness_program_.use();
    nearness_program_.texture("lowest", 0, GL_TEXTURE_2D, lowest_.id());
    nearness_program_.set("ground_height", ground);
    nearness_program_.set("reach", reach);
    gl::draw_screen();
    average(nearness_);

    gl::draw_into(map_target_, ground_size, ground_size);
    program.use();
    light_.bind(program);
    program.texture("nearness", 0, GL_TEXTURE_2D, nearness_.id());
    program.set("reach", Eigen::Vector4f(0.5f * reach / area_.z()));
    bind_shadow(program, 1);
    program.set("least_blur", 3.5f * area_.z() / static_cast<float>(ground_size));
    program.set("ground_area", area_);
    program.set("ground_height", ground);
    program.set("shadow_tint", tint);
    program.set("key_share", key_share);
    gl::draw_screen();
}

void GroundLight::bind_shadow(gl::Program& program, int unit) const {
    Eigen::Matrix4f to_texture = Eigen::Matrix4f::Identity();
    to_texture.topLeftCorner<3, 3>() *= 0.5f;
    to_texture.topRightCorner<3, 1>().setConstant(0.5f);
    std::vector<Eigen::Matrix4f> to_light;
    std::vector<Eigen::Vector4f> texels;
    for (std::size_t k = 0; k < light_matrices_.size(); ++k) {
        to_light.emplace_back(to_texture * light_matrices_[k]);
        // Half of the map's width is 1/(scale of the matrix).
        texels.emplace_back(2 / (static_cast<float>(light_size) * light_matrices_[k].block<1, 3>(0, 0).norm()), 0, 0, 0);
    }
    if (!light_.named) texels[0].x() = 2 * radius_ / static_cast<float>(light_size);
    program.texture("open_map", unit, GL_TEXTURE_2D, open_.id());
    program.texture("blocker_map", unit + 1, GL_TEXTURE_2D, blockers_.id());
    program.set("to_light", to_light);
    program.set("light", light_.lamps[0].place);
    program.set("light_centre", centre_);
    program.set("light_texel", texels);
    program.set("least_blur", 3 * radius_ / static_cast<float>(light_size));
    program.set("light_size", surround_lamp_size);
}

void GroundLight::bind_ground(gl::Program& program, int unit) const {
    program.set("ground_area", area_);
    program.texture("ground_light", unit, GL_TEXTURE_2D, map_.id());
}

namespace {

constexpr int coarser = 3;

}  // namespace

SolidLight::SolidLight(int width, int height)
    : width_((width + coarser - 1) / coarser), height_((height + coarser - 1) / coarser),
      light_(gl::texture_2d(GL_RGBA16F, width_, height_, false)), place_(gl::texture_2d(GL_RGBA16F, width_, height_, false)),
      depth_(gl::texture_2d(GL_DEPTH24_STENCIL8, width_, height_, false)),
      target_(gl::framebuffer({light_.id(), place_.id()}, depth_.id())) {}

void SolidLight::begin(const Eigen::Matrix4f& camera, const std::function<void(gl::Program&)>& faces) {
    camera_ = camera;
    gl::draw_into(target_, width_, height_);
    glClearColor(0, 0, 0, 0);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    glEnable(GL_DEPTH_TEST);
    mask_.use();
    faces(mask_);
    glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    gl::draw_screen();
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glDepthFunc(GL_EQUAL);
}

void SolidLight::end() const { glDepthFunc(GL_LESS); }

void SolidLight::bind(gl::Program& program, int unit) const {
    program.texture("light_kept", unit, GL_TEXTURE_2D, light_.id());
    program.texture("place_kept", unit + 1, GL_TEXTURE_2D, place_.id());
    program.set("to_kept", camera_);
}

namespace {

constexpr float cells_across = 6;
// An image shows a glow darker than it is, since its true brightness would be shown as white. Lit surfaces get its true brightness.
constexpr float true_brightness = 3;

}  // namespace

std::vector<EmissivePatch> hot_patches(const Surface& surface, const Material& material) {
    const TriangleMesh& mesh = surface.mesh;
    if (material.refracts || material.emission.isZero() || mesh.triangle.empty()) return {};
    const Bounds bounds = bounds_of(mesh.position);
    const float cell = std::max((bounds.high - bounds.low).maxCoeff() / cells_across, 1e-6f);
    std::map<std::array<int, 3>, EmissivePatch> patches;  // sums over triangles; `place` is weighted by the light
    for (const auto& t : mesh.triangle) {
        const Vec3f a = mesh.position[t[0]], b = mesh.position[t[1]], c = mesh.position[t[2]];
        const Vec3f middle = (a + b + c) / 3, normal = 0.5f * (b - a).cross(c - a);
        const float area = normal.norm();
        float heat = 0.3f;  // mean of a body that glows only in its folds
        if (!surface.age.empty() && material.cooling > 0) heat = heat_of_crust(surface.age[t[0]] / material.cooling);
        const Vec3f place = (middle - bounds.low) / cell;
        EmissivePatch& patch = patches[{static_cast<int>(std::floor(place.x())), static_cast<int>(std::floor(place.y())),
                                        static_cast<int>(std::floor(place.z()))}];
        const Vec3f light = true_brightness * area * glow_of(material.emission, heat);
        patch.place += light.x() * middle;
        patch.normal += normal;
        patch.light += light;
        patch.area += area;
    }
    std::vector<EmissivePatch> list;
    for (auto& [key, patch] : patches) {
        if (patch.area <= 0 || patch.light.x() <= 1e-12f) continue;
        patch.place /= patch.light.x();
        patch.normal /= patch.area, patch.light /= patch.area;
        list.push_back(patch);
    }
    std::stable_sort(list.begin(), list.end(),
                     [](const EmissivePatch& a, const EmissivePatch& b) { return a.light.x() * a.area > b.light.x() * b.area; });
    list.resize(std::min<std::size_t>(list.size(), most_patches));
    return list;
}

void bind_patches(gl::Program& program, const std::vector<EmissivePatch>& patches) {
    std::vector<Eigen::Vector4f> place, normal, light;
    for (const EmissivePatch& p : patches) {
        place.emplace_back(p.place.x(), p.place.y(), p.place.z(), p.area);
        normal.emplace_back(p.normal.x(), p.normal.y(), p.normal.z(), 0);
        light.emplace_back(p.light.x(), p.light.y(), p.light.z(), 0);
    }
    program.set("patches", static_cast<int>(patches.size()));
    program.set("patch_place", place);
    program.set("patch_normal", normal);
    program.set("patch_light", light);
}

}  // namespace whorl
