#include "render/look/lamps.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace whorl {
namespace {

constexpr float usual_light = 0.7f;

Lamp lamp_of(const Light& light) {
    constexpr float half_turn = std::numbers::pi_v<float>;
    Lamp lamp;
    lamp.light = usual_light * light.strength * light.colour;
    if (light.kind == "sun") {
        const float radius = 0.5f * light.angle * half_turn / 180;
        lamp.place = -light.direction.normalized();
        lamp.size = std::tan(radius);
        lamp.radiance = lamp.light / (std::sin(radius) * std::sin(radius));
        return lamp;
    }
    const Vec3f way = *light.target - light.position;
    lamp.near = true;
    lamp.place = light.position;
    lamp.light *= way.squaredNorm();
    lamp.size = light.radius;
    lamp.radiance = lamp.light / (light.radius * light.radius);
    if (light.kind == "soft_box") {
        const float area = light.size[0] * light.size[1];
        lamp.axis = way.normalized();
        const Vec3f level = lamp.axis.cross(Vec3f::UnitY());
        const Vec3f across = level.norm() > 1e-3f ? Vec3f(level.normalized()) : Vec3f(Vec3f::UnitX());
        lamp.across = 0.5f * light.size[0] * across;
        lamp.up = 0.5f * light.size[1] * across.cross(lamp.axis).normalized();
        lamp.size = std::sqrt(area / half_turn);
        lamp.radiance = half_turn / area * lamp.light;
    }
    return lamp;
}

}  // namespace

std::vector<Lamp> lamps_of(const std::vector<Light>& lights) {
    std::vector<Lamp> lamps;
    for (const Light& light : lights) lamps.push_back(lamp_of(light));
    return lamps;
}

}  // namespace whorl
