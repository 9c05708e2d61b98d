#include "render/flow/difference_field.h"

#include <algorithm>

#include "render/flow/plane_field.h"
#include "render/look/colour_map.h"
#include "render/look/field_values.h"

namespace whorl {
namespace {

std::vector<float> values_of(const Frame& frame, const LookOptions& look) {
    if (look.field != "ink") return field_values(frame, look);
    std::vector<float> values(frame.position.size(), 0.0f);
    if (const auto ink = frame.vector.find("ink"); ink != frame.vector.end())
        for (std::size_t p = 0; p < values.size(); ++p) values[p] = ink->second[p][0];
    return values;
}

}  // namespace

DifferenceField difference_field(const Frame& one, const Frame& other, const LookOptions& look, const PixelPlane& plane) {
    const PlaneField first = plane_field(one, {values_of(one, look)}, plane), second = plane_field(other, {values_of(other, look)}, plane);
    DifferenceField field{plane, second.value[0], second.cover};
    for (std::size_t k = 0; k < field.value.size(); ++k) {
        field.value[k] -= first.value[0][k];
        field.cover[k] = std::min(field.cover[k], first.cover[k]);
    }
    return field;
}

FlowSlice coloured(const DifferenceField& field, const std::string& colour_map, const std::array<float, 2>& range) {
    const ColourTable colours(colour_map);
    FlowSlice slice{field.plane, std::vector<float>(4 * field.value.size())};
    for (std::size_t k = 0; k < field.value.size(); ++k) {
        const Vec3f colour = colours((field.value[k] - range[0]) / (range[1] - range[0]));
        for (int c = 0; c < 3; ++c) slice.rgba[4 * k + c] = colour[c];
        slice.rgba[4 * k + 3] = flow_cover(field.cover[k]);
    }
    return slice;
}

}  // namespace whorl
