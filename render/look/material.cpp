#include "render/look/material.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "render/look/colour_map.h"

namespace whorl {
namespace {

constexpr float table_size = 0.4f;  // m, largest diagonal of a scene whose liquids look as they do in a kitchen

const std::vector<std::pair<std::string, Material>>& fluid_presets() {
    static const std::vector<std::pair<std::string, Material>> presets = [] {
        Material honey;  // a 5 mm thread is gold, a 40 mm pile amber
        honey.absorption = {8, 45, 220};
        honey.scatter = {1.2f, 0.53f, 0.022f};
        honey.haze = 45;
        Material water;
        water.absorption = {5.0f, 1.6f, 1.0f};
        water.refraction = 1.333f;
        water.scatter = {0.25f, 0.6f, 0.7f};
        water.haze = 0.3f;
        Material paint;
        paint.refracts = false;
        paint.colour = {0.02f, 0.16f, 0.55f};
        paint.roughness = 0.12f;
        paint.softness = 0.15f;
        Material chocolate;
        chocolate.refracts = false;
        chocolate.colour = {0.105f, 0.038f, 0.016f};
        chocolate.roughness = 0.22f;
        chocolate.softness = 0.35f;
        Material lava;
        lava.refracts = false;
        lava.colour = {0.034f, 0.027f, 0.023f};
        lava.emission = {3.2f, 0.70f, 0.05f};
        lava.roughness = 1;
        lava.cooling = 1.5f;
        Material clay;
        clay.refracts = false;
        clay.colour = {0.42f, 0.17f, 0.09f};
        clay.roughness = 0.75f;
        clay.softness = 0.3f;
        // Reflectance and mean free path of cream and milk: Jensen et al. (2001), table 1.
        Material cream;
        cream.refracts = false;
        cream.colour = {0.98f, 0.90f, 0.73f};
        cream.roughness = 0.2f;
        cream.scattering = 0.19e-3f;
        Material milk = cream;
        milk.colour = {0.91f, 0.88f, 0.76f};
        milk.roughness = 0.08f;
        milk.scattering = 0.31e-3f;
        Material wax = cream;
        wax.colour = {0.90f, 0.82f, 0.66f};
        wax.roughness = 0.35f;
        wax.scattering = 1.2e-3f;
        // Jensen et al. (2001), table 1: reflectance, index, and a mean free path between those of red (4.1 mm) and green (0.96 mm).
        Material ketchup = cream;
        ketchup.colour = {0.16f, 0.01f, 0.002f};
        ketchup.roughness = 0.12f;
        ketchup.scattering = 2e-3f;
        // No measurements of caramel and slime are known: values by eye.
        Material caramel = cream;
        caramel.colour = {0.45f, 0.17f, 0.035f};
        caramel.roughness = 0.1f;
        caramel.scattering = 1e-3f;
        Material slime;
        slime.absorption = {60, 4, 90};
        slime.refraction = 1.34f;
        slime.scatter = {0.30f, 0.85f, 0.12f};
        slime.haze = 60;
        return std::vector<std::pair<std::string, Material>>{
            {"honey", honey}, {"water", water}, {"paint", paint}, {"chocolate", chocolate}, {"lava", lava},       {"clay", clay},
            {"cream", cream}, {"milk", milk},   {"wax", wax},     {"caramel", caramel},     {"ketchup", ketchup}, {"slime", slime}};
    }();
    return presets;
}

const std::vector<std::pair<std::string, SolidMaterial>>& solid_presets() {
    static const std::vector<std::pair<std::string, SolidMaterial>> presets{
        {"ceramic", {{0.72f, 0.70f, 0.66f}, 0.18f, 0, Pattern::plain}},
        {"white", {{0.82f, 0.82f, 0.82f}, 0.5f, 0, Pattern::plain}},
        {"metal", {{0.78f, 0.77f, 0.75f}, 0.2f, 1, Pattern::plain}},
        {"wood", {{0.46f, 0.26f, 0.12f}, 0.5f, 0, Pattern::wood_rings}},
        {"clay", {{0.42f, 0.17f, 0.09f}, 0.8f, 0, Pattern::plain}},
        {"dark", {{0.05f, 0.05f, 0.055f}, 0.35f, 0, Pattern::plain}},
        {"rock", {{0.10f, 0.09f, 0.085f}, 1.0f, 0, Pattern::rock}},
        {"glass", {{0.85f, 0.9f, 0.9f}, 0.05f, 0, Pattern::plain, 1.5f, {4, 1, 2}}},
        // Ratios of the absorption as measured (Warren and Brandt 2008), ten times as strong, so that a small piece looks like a block.
        {"ice", {{0.9f, 0.95f, 1.0f}, 0.25f, 0, Pattern::plain, 1.31f, {2.5f, 0.6f, 0.2f}}},
        {"cloth", {{0.72f, 0.68f, 0.60f}, 1.0f, 0, Pattern::cloth}},
    };
    return presets;
}

const std::vector<std::pair<std::string, SolidMaterial>>& table_presets() {
    static const std::vector<std::pair<std::string, SolidMaterial>> presets{
        {"none", {{0, 0, 0}, 1.0f, 0, Pattern::paper}},
        {"plain", {{0.55f, 0.53f, 0.50f}, 0.5f, 0, Pattern::plain}},
        {"wood", {{0.40f, 0.23f, 0.12f}, 0.45f, 0, Pattern::planks}},
        {"stone", {{0.30f, 0.30f, 0.305f}, 0.4f, 0, Pattern::slab}},
        {"cloth", {{0.72f, 0.68f, 0.60f}, 1.0f, 0, Pattern::cloth}},
    };
    return presets;
}

template <class T>
const T& named(const std::vector<std::pair<std::string, T>>& presets, const std::string& name) {
    for (const auto& [known, preset] : presets)
        if (known == name) return preset;
    return presets.front().second;
}

template <class T>
std::vector<std::string> names_of(const std::vector<std::pair<std::string, T>>& presets) {
    std::vector<std::string> names;
    for (const auto& [name, preset] : presets) names.push_back(name);
    return names;
}

}  // namespace

Material fluid_material(const LookOptions& look, float size) {
    Material material = named(fluid_presets(), look.material);
    const float scale = std::min(1.0f, table_size / std::max(size, 1e-6f));
    material.absorption *= scale;
    material.haze *= scale;
    material.scattering /= scale;
    if (look.style == "opaque") material.refracts = false;
    if (look.absorption.minCoeff() >= 0) material.absorption = look.absorption;
    if (look.colour.minCoeff() >= 0) material.colour = look.colour;
    if (look.refraction >= 1) material.refraction = look.refraction;
    if (look.roughness >= 0) material.roughness = look.roughness;
    if (look.cooling >= 0) material.cooling = look.cooling;
    if (look.scattering >= 0) material.scattering = look.scattering;
    return material;
}

float hides(const Material& material, float size) {
    // A clear body scatters part of the light that it removes from a ray back out.
    return material.refracts ? 0.75f * (1 - std::exp(-(material.absorption.mean() + material.haze) * size / 8)) : 1;
}

Vec3f diffuse_attenuation(const Material& material) {
    return material.colour.unaryExpr([&](float colour) {
        float low = 0, high = 1;  // albedo
        for (int k = 0; k < 24; ++k) {
            const float albedo = (low + high) / 2, root = std::sqrt(3 * (1 - albedo));
            const float reflected = albedo / 2 * (1 + std::exp(-4.0f / 3 * inner_reflection * root)) * std::exp(-root);
            (reflected < std::min(colour, 0.99f) ? low : high) = albedo;
        }
        return std::sqrt(3 * (1 - low)) / material.scattering;
    });
}

Vec3f sideways_reach(const Material& material) {
    return material.colour.unaryExpr([&](float R) { return 2.5f * material.scattering / (1.9f - R + 3.5f * (R - 0.8f) * (R - 0.8f)); });
}

Vec3f glow_of(const Vec3f& emission, float heat) {
    return {0.5f * emission.x() * std::pow(heat, 1.2f), emission.y() * std::pow(heat, 2.4f), 2 * emission.z() * std::pow(heat, 4.0f)};
}

float heat_of_crust(float age) { return std::max(std::exp(-1.2f * age), 0.35f * std::exp(-0.15f * age)); }

SolidMaterial solid_material(const std::string& name) { return named(solid_presets(), name); }
SolidMaterial solid_material(const Appearance& appearance) {
    SolidMaterial material = solid_material(appearance.material);
    if (!appearance.texture.empty()) material.pattern = Pattern::picture, material.colour = Vec3f::Ones();
    if (appearance.colour.minCoeff() >= 0) {
        material.colour = appearance.colour;
        constexpr float centimetre = 0.01f;
        if (material.refraction > 0) material.absorption = -material.colour.cwiseMax(1e-3f).array().log().matrix() / centimetre;
    }
    if (appearance.roughness >= 0) material.roughness = appearance.roughness;
    if (appearance.metallic >= 0) material.metal = appearance.metallic;
    return material;
}
SolidMaterial table_material(const std::string& name) { return named(table_presets(), name); }

std::vector<std::string> material_names() { return names_of(fluid_presets()); }
std::vector<std::string> solid_material_names() { return names_of(solid_presets()); }
std::vector<std::string> table_names() { return names_of(table_presets()); }

namespace {

/// Scattering S of an ink of concentration 1, large enough to hide the ground.
constexpr float hiding = 8;

}  // namespace

std::array<Vec3f, 3> absorption_ratios(const std::vector<std::string>& colours) {
    std::array<Vec3f, 3> ratio;
    ratio.fill(Vec3f::Zero());
    for (std::size_t k = 0; k < std::min(colours.size(), ratio.size()); ++k) {
        Vec3f colour = Vec3f::Ones();
        read_colour(colours[k], colour);
        // No pigment absorbs or reflects all light of a band.
        ratio[k] = linear_of(colour).unaryExpr([](float reflected) {
            const float R = std::clamp(reflected, 0.005f, 0.98f);
            return (1 - R) * (1 - R) / (2 * R);
        });
    }
    return ratio;
}

Pigments::Pigments(const std::vector<std::string>& colours, const Vec3f& ground)
    : absorption_(absorption_ratios(colours)), ground_(ground) {}

Vec3f Pigments::operator()(const Vec3f& concentration) const {
    const float amount = concentration.sum();
    if (!(amount > 1e-5f)) return ground_;
    // S grows faster than the amount, because a little of a strong pigment tints a lot: with S proportional to the amount, one part in a
    // thousand would absorb a quarter of the red.
    const float S = hiding * amount * std::sqrt(amount);
    Vec3f colour;
    for (int band = 0; band < 3; ++band) {
        float ratio = 0;
        for (int k = 0; k < 3; ++k) ratio += concentration[k] / amount * absorption_[k][band];
        const float a = 1 + ratio, b = std::sqrt(ratio * (2 + ratio)), ground = ground_[band];
        const float q = b * S < 1e-3f ? 1 / S : b / std::tanh(b * S);
        colour[band] = (1 - ground * (a - q)) / (a - ground + q);
    }
    return colour;
}

}  // namespace whorl
