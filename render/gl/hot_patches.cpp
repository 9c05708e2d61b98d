#include "render/gl/hot_patches.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "render/gl/setup.h"

namespace whorl {
namespace {

constexpr float cells_across = 6;
// A picture shows a glow darker than it is, or it would have no colour. What it lights shows how bright it is.
constexpr float true_brightness = 3;

}  // namespace

std::vector<HotPatch> hot_patches(const Surface& surface, const Material& material) {
    const TriangleMesh& mesh = surface.mesh;
    if (material.refracts || material.emission.isZero() || mesh.triangle.empty()) return {};
    const Bounds bounds = bounds_of(mesh.position);
    const float cell = std::max((bounds.high - bounds.low).maxCoeff() / cells_across, 1e-6f);
    std::map<std::array<int, 3>, HotPatch> patches;  // sums over their area, weighed by the light
    for (const auto& t : mesh.triangle) {
        const Vec3f a = mesh.position[t[0]], b = mesh.position[t[1]], c = mesh.position[t[2]];
        const Vec3f middle = (a + b + c) / 3, normal = 0.5f * (b - a).cross(c - a);
        const float area = normal.norm();
        float heat = 0.3f;  // of a body that glows in its folds alone
        if (!surface.age.empty() && material.cooling > 0) heat = heat_of_crust(surface.age[t[0]] / material.cooling);
        const Vec3f place = (middle - bounds.low) / cell;
        HotPatch& patch = patches[{static_cast<int>(std::floor(place.x())), static_cast<int>(std::floor(place.y())),
                                   static_cast<int>(std::floor(place.z()))}];
        const Vec3f light = true_brightness * area * glow_of(material.emission, heat);
        patch.place += light.x() * middle;
        patch.normal += normal;
        patch.light += light;
        patch.area += area;
    }
    std::vector<HotPatch> list;
    for (auto& [key, patch] : patches) {
        if (patch.area <= 0 || patch.light.x() <= 1e-12f) continue;
        patch.place /= patch.light.x();
        patch.normal /= patch.area, patch.light /= patch.area;
        list.push_back(patch);
    }
    std::stable_sort(list.begin(), list.end(),
                     [](const HotPatch& a, const HotPatch& b) { return a.light.x() * a.area > b.light.x() * b.area; });
    list.resize(std::min<std::size_t>(list.size(), most_patches));
    return list;
}

void bind_patches(gl::Program& program, const std::vector<HotPatch>& patches) {
    std::vector<Eigen::Vector4f> place, normal, light;
    for (const HotPatch& p : patches) {
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
