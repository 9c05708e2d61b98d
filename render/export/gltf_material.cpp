#include "render/export/gltf_material.h"

#include <fmt/format.h>

#include "render/look/material.h"

namespace whorl {
namespace {

/// Light passes through the material, is refracted, and absorbed inside. Its roughness is left out: in Whorl it is the unevenness of a
/// clear surface; in glTF it would make the material frosted.
void refract(Json& description, const SolidMaterial& look) {
    constexpr float depth = 0.01f;  // m, at which light has the attenuation colour
    description["extensions"] = {{"KHR_materials_transmission", {{"transmissionFactor", 1}}},
                                 {"KHR_materials_ior", {{"ior", look.refraction}}},
                                 {"KHR_materials_volume",
                                  {{"thicknessFactor", depth},
                                   {"attenuationDistance", depth},
                                   {"attenuationColor", numbers(Vec3f((-depth * look.absorption).array().exp()))}}}};
}

}  // namespace

std::string material_name(const FrameSolid& solid) {
    if (solid.container) return "glass of a container";
    const Appearance& a = solid.appearance;
    if (a.colour.minCoeff() < 0 && a.roughness < 0 && a.metallic < 0 && a.texture.empty()) return a.material;
    const SolidMaterial m = solid_material(a);
    const std::string picture =
        a.texture.empty() ? "" : fmt::format("; {} {:g}", a.texture.filename().string(), a.texture_size.value_or(0));
    return fmt::format("{} ({:.3g}, {:.3g}, {:.3g}; {:g}; {:g}{})", a.material, m.colour.x(), m.colour.y(), m.colour.z(), m.roughness,
                       m.metal, picture);
}

Json material_json(const FrameSolid& solid) {
    const SolidMaterial look = solid.container ? solid_material("glass") : solid_material(solid.appearance);
    const bool glass = look.refraction > 0 && !solid.container;
    const Vec3f base = glass ? Vec3f(Vec3f::Ones()) : look.colour;
    Json description{{"name", material_name(solid)},
                     {"pbrMetallicRoughness",
                      {{"baseColorFactor", {base.x(), base.y(), base.z(), solid.container ? 0.1f : 1.0f}},
                       {"metallicFactor", look.metal},
                       {"roughnessFactor", glass ? 0 : look.roughness}}},
                     {"doubleSided", true}};
    if (solid.container) description["alphaMode"] = "BLEND";
    if (glass) refract(description, look);
    return description;
}

}  // namespace whorl
