#include "render/gl/scene_lighting.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/core/random.h"
#include "render/look/environment.h"
#include "render/look/lamps.h"
#include "render/look/material.h"

namespace whorl {
namespace {

constexpr float darkest = 1e-4f;        // least strength of the surround: lamps light the ground relative to it
constexpr float far_below = -1e6f;      // m, height of the ground if there is none
constexpr float brightest = 1000;       // upper bound of radiance: the sun itself would turn single pixels of soft reflections white
constexpr float round_share = 0.7f;     // fraction of the panorama's light that becomes ambient light
constexpr float directed_share = 0.6f;  // fraction of the excess of its brightest side over the opposite side that becomes the lamp

gl::Texture texture_of(const Environment& environment) {
    std::vector<float> rgba;
    rgba.reserve(environment.rgb.size() / 3 * 4);
    for (std::size_t i = 0; i < environment.rgb.size(); ++i) {
        rgba.push_back(std::clamp(environment.rgb[i], 0.0f, brightest));
        if (i % 3 == 2) rgba.push_back(1);
    }
    gl::Texture texture = gl::texture_2d(GL_RGBA16F, environment.width, environment.height, true);
    glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, environment.width, environment.height, GL_RGBA, GL_FLOAT, rgba.data());
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_REPEAT);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
    glGenerateMipmap(GL_TEXTURE_2D);
    return texture;
}

}  // namespace

SceneLighting::SceneLighting() : noise_(lattice_noise()), picture_(gl::texture_2d(GL_RGBA16F, 1, 1, true)) { light_.fill(Vec3f::Zero()); }

void SceneLighting::fill(const LookOptions& look) {
    if (look.environment == file_) return;
    if (!look.environment.empty()) {
        const Environment environment = read_environment(look.environment);
        picture_ = texture_of(environment);
        light_ = light_of(environment);
    }
    file_ = look.environment;
}

Studio SceneLighting::studio(const LookOptions& look) const {
    Studio studio = studio_of(look.background);
    const float strength = std::max(look.surround_strength, darkest);
    if (file_.empty()) return scaled(studio, strength);
    const Vec3f lamp = brightest_side(light_);
    studio.sky = light_on(light_, Vec3f::UnitY());
    studio.sun = directed_share * (light_on(light_, lamp) - light_on(light_, -lamp)).cwiseMax(0.0f);
    studio.backdrop_low = light_on(light_, -Vec3f::UnitY());
    return scaled(studio, strength);
}

Vec3f SceneLighting::shadow_lamp(const LookOptions& look, const View& view) const {
    const Mat3f turned = turned_back(look.surround_turn);
    return file_.empty() ? Vec3f((turned * studio_axes(view)).transpose() * shadow_light())
                         : Vec3f(turned.transpose() * brightest_side(light_));
}

LampLight SceneLighting::lamps(const LookOptions& look, const View& view) const {
    LampLight all;
    const Vec3f towards = shadow_lamp(look, view);
    if (look.lights.empty()) {
        all.lamps.emplace_back().place = towards;
        all.lamps[0].size = surround_lamp_size;
        return all;
    }
    all.lamps = lamps_of(look.lights);
    all.named = true;
    const Studio light = studio(look);
    all.share = key_share / std::max({light.sun.mean() * towards.y(), 0.1f * light.sky.mean(), 1e-9f});
    return all;
}

void LampLight::bind(gl::Program& program) const {
    if (!named) return;
    std::vector<Eigen::Vector4f> place, axis, across, up, light, radiance;
    const auto add = [](std::vector<Eigen::Vector4f>& to, const Vec3f& v, float w) { to.emplace_back(v.x(), v.y(), v.z(), w); };
    for (const Lamp& lamp : lamps) {
        add(place, lamp.place, lamp.near ? 1.0f : 0.0f), add(axis, lamp.axis, lamp.size), add(across, lamp.across, 0), add(up, lamp.up, 0);
        add(light, lamp.light, 0), add(radiance, lamp.radiance, 0);
    }
    program.set("lamp_place", place), program.set("lamp_axis", axis), program.set("lamp_across", across), program.set("lamp_up", up);
    program.set("lamp_light", light), program.set("lamp_radiance", radiance);
    program.set("lamp_share", share);
    program.set("surround_share", 1 - key_share);
}

std::string SceneLighting::constants(const LookOptions& look) const {
    return gl::constant("table", static_cast<int>(table_material(look.table).pattern)) + gl::constant("has_environment", !file_.empty()) +
           gl::constant("lamps", static_cast<int>(look.lights.size()));
}

void SceneLighting::bind(gl::Program& program, const LookOptions& look, const View& view, float ground, int height, int unit) const {
    const Studio light = studio(look);
    const Mat3f turned = turned_back(look.surround_turn);
    program.set("studio", studio_axes(view));
    program.set("boxes", Mat3f(turned * studio_axes(view)));
    program.set("environment_axes", turned);
    program.set("surround_strength", std::max(look.surround_strength, darkest));
    lamps(look, view).bind(program);
    program.set("backdrop_low", light.backdrop_low);
    program.set("backdrop_high", light.backdrop_high);
    program.set("backdrop_glow", light.backdrop_glow);
    program.set("key_light", light.key);
    program.set("window_light", light.window);
    program.set("rim_light", light.rim);
    program.set("fill_light", light.fill);
    program.set("sky", light.sky);
    program.set("key_colour", light.sun);
    program.set("ground_height", look.ground ? ground : far_below);
    program.set("eye", view.position);
    program.set("pixel_angle", 2 * std::tan(view.fov * std::numbers::pi_v<float> / 360) / static_cast<float>(height));
    const SolidMaterial table = table_material(look.table);
    program.set("table_colour", table.colour);
    program.set("table_roughness", table.roughness);
    program.set("table_area", Vec3f(view.target.x(), view.target.z(), 0.5f * (view.target - view.position).norm()));
    std::vector<Eigen::Vector4f> terms;
    const float share = round_share * look.surround_strength;
    for (const Vec3f& c : light_) terms.emplace_back(share * c.x(), share * c.y(), share * c.z(), 0);
    program.set("environment_light", terms);
    program.texture("lattice_noise", unit, GL_TEXTURE_3D, noise_.id());
    program.texture("environment_map", unit + 1, GL_TEXTURE_2D, picture_.id());
}

gl::Texture lattice_noise() {
    constexpr int n = 64;
    RandomNumbers random(1);
    std::vector<float> value(n * n * n);
    for (float& v : value) v = static_cast<float>(random());
    gl::Texture texture;
    gl::fill_3d(texture, n, n, n, value.data());
    glGenerateMipmap(GL_TEXTURE_3D);
    glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
    for (const GLenum axis : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T, GL_TEXTURE_WRAP_R}) glTexParameteri(GL_TEXTURE_3D, axis, GL_REPEAT);
    return texture;
}

Backdrop::Backdrop(int width, int height)
    : width_(width), height_(height), paper_(gl::texture_2d(GL_RGBA16F, width, height, true)), target_(gl::framebuffer({paper_.id()}, 0)) {}

void Backdrop::draw(const Key& key, const std::string& constants, const std::function<void(gl::Program&)>& prepare) {
    if (key_ == key) return;
    key_ = key;
    gl::Program& program = program_.with(constants);
    prepare(program);
    program.set("to_ray", key.to_ray);
    gl::draw_into(target_, width_, height_);
    gl::draw_screen();
}

void Backdrop::bind(gl::Program& program, int unit) const {
    program.texture("paper", unit, GL_TEXTURE_2D, paper_.id());
    // The ray along r meets the ground at eye + r (ground - eye.y)/r.y.
    Mat3f to_ground;
    const Mat3f& ray = key_->to_ray;
    for (const int row : {0, 1}) to_ground.row(row) = key_->eye[2 * row] * ray.row(1) + (key_->ground - key_->eye.y()) * ray.row(2 * row);
    to_ground.row(2) = ray.row(1);
    program.set("to_ground", to_ground);
    program.set("to_paper", Mat3f(ray.inverse()));
    program.set("paper_eye", key_->eye);
}

}  // namespace whorl
