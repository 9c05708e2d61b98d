#include "render/look/field_values.h"

#include <algorithm>
#include <cmath>
#include <map>

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
    if (look.field == "q_criterion" && !is_diverging(look.colour_map)) low = 0;  // no vortex has Q < 0
    if (is_diverging(look.colour_map)) high = std::max(std::abs(low), std::abs(high)), low = -high;
    if (high <= low) high = low + 1;
    return {low, high};
}

std::string unit_of(const std::string& quantity) {
    static const std::map<std::string, std::string> units{
        {"position", "m"}, {"velocity", "m/s"},  {"density", "kg/m^3"},    {"pressure", "Pa"},         {"viscosity", "Pa s"},
        {"spin", "1/s"},   {"vorticity", "1/s"}, {"q_criterion", "1/s^2"}, {"spin_difference", "1/s"}, {"age", "s"},
        {"radius", "m"},   {"speed", "m/s"},     {"temperature", "K"}};
    const auto found = units.find(quantity);
    return found == units.end() ? "" : found->second;
}

namespace {

/// In a volume, each colour is that of the undiluted mixture (concentrations scaled to sum 1). The amount of ink determines the strength,
/// whose square is the density. Ink is three times as dense as other fields, because those fill the whole fluid.
FieldColours ink_colours(const Frame& frame, const LookOptions& look) {
    const Pigments pigments(look.inks.of, Vec3f::Constant(0.9f));
    FieldColours colours;
    const auto ink = frame.vector.find("ink");
    for (std::size_t p = 0; p < frame.position.size(); ++p) {
        const Vec3f c = ink == frame.vector.end() ? Vec3f(Vec3f::Zero()) : Vec3f(ink->second[p].cwiseMax(0.0f).cwiseMin(1.0f));
        colours.strength.push_back(std::sqrt(3 * c.sum()));
        colours.colour.push_back(pigments(look.style == "volume" && c.sum() > 0 ? Vec3f(c / c.sum()) : c));
    }
    return colours;
}

}  // namespace

FieldColours field_colours(const Frame& frame, const LookOptions& look, const std::array<float, 2>& range) {
    if (look.field == "ink") return ink_colours(frame, look);
    const ColourTable table(look.colour_map);
    const bool diverging = is_diverging(look.colour_map);
    FieldColours colours;
    for (const float value : field_values(frame, look)) {
        const float t = std::clamp((value - range[0]) / (range[1] - range[0]), 0.0f, 1.0f);
        colours.colour.push_back(table(t));
        colours.strength.push_back(diverging ? std::abs(2 * t - 1) : range[1] < range[0] ? 1 - t : t);
    }
    return colours;
}

Frame inked_points(const Frame& frame) {
    const FrameMarkers& markers = frame.ink_markers;
    Frame points = frame;
    points.scalar.clear(), points.whole.clear();
    if (markers.position.empty()) return points;
    points.spacing = markers.spacing, points.position = markers.position;
    points.velocity.assign(markers.position.size(), Vec3f::Zero());
    points.vector = {{"ink", markers.ink}};
    return points;
}

std::vector<std::string> shown_fields(const LookOptions& look) {
    if (look.style == "slice" && look.streaks) return {look.field, "grain"};
    if (draws_lines(look)) return {look.field, "vorticity", "grain"};
    if (shows_field(look)) return {look.field};
    std::vector<std::string> fields{"ink"};
    if (fluid_material(look, 1).cooling > 0) fields.insert(fields.end(), {"age", "temperature", "grain"});
    if (look.foam > 0) fields.insert(fields.end(), {"foam", "airborne", "grain"});
    return fields;
}

}  // namespace whorl
