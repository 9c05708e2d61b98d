
#include <algorithm>
#include <cmath>

#include "engine/core/parallel.h"
#include "render/surface/particle_rows.h"
#include "render/surface/vertex_values.h"

namespace whorl {
namespace {

constexpr float large_plate = 7, small_plate = 3;  // widths [spacings]
constexpr float beyond = 10;                       // edge distance if no edge is found [spacings]

struct Plate {
    float edge = beyond;  ///< spacings
    Index middle = -1;    ///< index among the middles; -1: none
};

/// The particles that are middles of plates of a given width.
struct Middles {
    Middles(Span<const Vec3f> particle, Span<const float> grain, float width, float spacing)
        : reach(2.5f * width * spacing), position(chosen(particle, grain, width)), rows(position, reach) {}

    /// Plate of the nearest middle. The bisecting plane to another middle bounds it; `edge` is the distance to the nearest such plane.
    Plate at(const Vec3f& x) const {
        Plate plate;
        float nearest = reach * reach;
        visit(x, [&](Index i, float d2) {
            if (d2 < nearest) nearest = d2, plate.middle = i;
        });
        if (plate.middle < 0) return plate;
        plate.edge = reach;
        const Vec3f own = position[plate.middle];
        visit(x, [&](Index i, float d2) {
            if (i == plate.middle) return;
            // (|x - b|^2 - |x - a|^2) / (2 |b - a|): the distance to the plane, linear in x.
            plate.edge = std::min(plate.edge, 0.5f * (d2 - nearest) / std::max((position[i] - own).norm(), 1e-9f));
        });
        return plate;
    }

    const float reach;  ///< m
    const std::vector<Vec3f> position;

private:
    const ParticleRows rows;

    static std::vector<Vec3f> chosen(Span<const Vec3f> particle, Span<const float> grain, float width) {
        const float share = 1 / (width * width * width);
        std::vector<Vec3f> middles;
        for (std::size_t i = 0; i < particle.size(); ++i)
            if (grain[i] < share) middles.push_back(particle[i]);
        return middles;
    }

    template <class F>
    void visit(const Vec3f& x, F&& f) const {
        rows.near(x, reach, [&](Index i, const Vec3f& r) { f(rows.original[i], r.squaredNorm()); });
    }
};

/// Derives another number between 0 and 1 from the later digits of one.
float further(float number, float factor) { return number * factor - std::floor(number * factor); }

}  // namespace

std::vector<CrustPlace> crust_places(Span<const Vec3f> vertex, Span<const Vec3f> particle, Span<const float> grain, float spacing) {
    std::vector<float> other(grain.size()), of_large;
    for (std::size_t i = 0; i < grain.size(); ++i) {
        other[i] = further(grain[i], 97);
        if (grain[i] < 1 / (large_plate * large_plate * large_plate)) of_large.push_back(further(grain[i], 5501));
    }
    const std::vector<float> varied = values_at(vertex, particle, other, 1.5f * spacing);
    const Middles large(particle, grain, large_plate, spacing), small(particle, other, small_plate, spacing);
    std::vector<CrustPlace> places(vertex.size());
    parallel_for(static_cast<Index>(vertex.size()), [&](Index v) {
        const Plate a = large.at(vertex[v]), b = small.at(vertex[v]);
        const float number = a.middle < 0 ? 0.5f : of_large[a.middle];
        places[v] = {a.edge / spacing, b.edge / spacing, number, std::clamp(0.5f + 2 * (varied[v] - 0.5f), 0.0f, 1.0f)};
    });
    return places;
}

}  // namespace whorl
