#include "render/look/field_values.h"

#include <algorithm>
#include <cmath>

#include "render/look/colour_map.h"
#include "render/look/material.h"

namespace whorl {

std::vector<float> field_values(const Frame& frame, const LookOptions& look) {
    std::vector<float> values;
    const auto norms = [&](const std::vector<Vec3f>& field, bool signed_z) {
        for (const Vec3f& v : field) values.push_back(signed_z ? v.z() : v.norm());
    };
    if (look.field == "speed") {
        norms(frame.velocity, false);
    } else if (const auto vector = frame.vector.find(look.field); vector != frame.vector.end()) {
        norms(vector->second, is_diverging(look.colour_map));
    } else if (const auto scalar = frame.scalar.find(look.field); scalar != frame.scalar.end()) {
        values = scalar->second;
    }
    values.resize(frame.position.size(), 0.0f);
    return values;
}

std::array<float, 2> field_range(const std::vector<float>& values, const LookOptions& look) {
    if (look.range[0] != look.range[1]) return look.range;
    float low = 1e30f, high = -1e30f;
    for (const float v : values)
        if (std::isfinite(v)) low = std::min(low, v), high = std::max(high, v);
    if (low > high) return {0, 1};
    if (is_diverging(look.colour_map)) high = std::max(std::abs(low), std::abs(high)), low = -high;
    if (high <= low) high = low + 1;
    return {low, high};
}

std::vector<std::string> shown_fields(const LookOptions& look) {
    if (shows_field(look)) return {look.field};
    return fluid_material(look, 1).cooling > 0 ? std::vector<std::string>{"age"} : std::vector<std::string>{};
}

}  // namespace whorl
