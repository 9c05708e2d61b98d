
#include <algorithm>
#include <cmath>

#include "engine/core/parallel.h"
#include "render/surface/particle_rows.h"
#include "render/surface/vertex_values.h"

namespace whorl {
namespace {

constexpr float plate_distance = 4.5f;  // mean distance of the middles of plates [spacings]
constexpr float largest_plate = 6;      // radius of a plate [spacings]
constexpr float plate_reach = largest_plate + 1.6f * plate_distance;

/// Plates in ascending order of their distance.
struct Nearest {
    std::array<float, 4> plate{-1, -1, -1, -1}, away{plate_reach, plate_reach, plate_reach, plate_reach};

    void add(Index i, float distance) {
        for (std::size_t k = 0; k < plate.size(); ++k) {
            if (!(distance < away[k])) continue;
            std::copy_backward(plate.begin() + k, plate.end() - 1, plate.end());
            std::copy_backward(away.begin() + k, away.end() - 1, away.end());
            plate[k] = static_cast<float>(i), away[k] = distance;
            return;
        }
    }
};

}  // namespace

Crust crust_of(Span<const Vec3f> vertex, const Frame& frame, Span<const float> grain) {
    constexpr float share = 1 / (plate_distance * plate_distance * plate_distance);
    Crust crust;
    std::vector<Vec3f> middle;
    for (std::size_t i = 0; i < grain.size(); ++i) {
        if (!(grain[i] < share)) continue;
        const float number = grain[i] / share;
        crust.plate.push_back({frame.position[i], largest_plate * std::pow(number, 4.0f) * frame.spacing, frame.velocity[i], number});
        middle.push_back(frame.position[i]);
    }
    const ParticleRows rows(middle, plate_reach * frame.spacing);
    // If two middles are close together, the larger plate replaces the other: the line between them would be undetermined.
    const float close = 0.8f * plate_distance * frame.spacing;
    std::vector<float> shrinks(middle.size(), 0);
    for (std::size_t k = 0; k < middle.size(); ++k)
        rows.near(middle[k], close, [&](Index i, const Vec3f& r) {
            if (crust.plate[rows.original[i]].number > crust.plate[k].number) shrinks[k] = std::max(shrinks[k], close - r.norm());
        });
    for (std::size_t k = 0; k < middle.size(); ++k) crust.plate[k].radius -= shrinks[k];
    crust.nearest.resize(vertex.size());
    parallel_for(static_cast<Index>(vertex.size()), [&](Index v) {
        Nearest nearest;
        rows.near(vertex[v], plate_reach * frame.spacing, [&](Index i, const Vec3f& r) {
            const Index plate = rows.original[i];
            nearest.add(plate, (r.norm() - crust.plate[plate].radius) / frame.spacing);
        });
        crust.nearest[v] = nearest.plate;
    });
    return crust;
}

}  // namespace whorl
