#include "render/surface/foam.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "engine/core/parallel.h"
#include "render/surface/ghosts.h"

namespace whorl {
namespace {

constexpr int usual_points = 48;      // largest number per particle, for amount = 1
constexpr float scatter = 1.3f;       // largest distance of a point from its particle [spacings]
constexpr float parting = 0.12f;      // (largest velocity of a point of spray relative to its particle)/(the particle's velocity)
constexpr float spray_after = 0.02f;  // `airborne` above which a particle is drawn as spray [s]
constexpr float faint = 0.06f;        // smaller values of foam are not drawn
constexpr float mist_radius = 1.0f;   // spacings
constexpr float mist_opacity = 0.24f, mist_of_spray = 0.12f;
constexpr float bubble_opacity = 0.45f;  // of a point in the fluid

/// Random numbers of a point, uniform from 0 to 1 (PCG, Jarzynski and Olano 2020).
class PointNumbers {
public:
    PointNumbers(float grain, int k) : state_(std::bit_cast<std::uint32_t>(grain) + 0x9e3779b9u * static_cast<std::uint32_t>(k + 1)) {}
    float next() {
        state_ = state_ * 747796405u + 2891336453u;
        std::uint32_t word = ((state_ >> ((state_ >> 28) + 4)) ^ state_) * 277803737u;
        word = (word >> 22) ^ word;
        return static_cast<float>(word >> 8) * 0x1p-24f;
    }
    /// Uniform in the unit ball.
    Vec3f in_ball() {
        const float z = 2 * next() - 1, turn = 6.2831853f * next(), r = std::cbrt(next()), flat = r * std::sqrt(1 - z * z);
        return {flat * std::cos(turn), flat * std::sin(turn), r * z};
    }

private:
    std::uint32_t state_;
};

const std::vector<float>* find_field(const Frame& frame, const char* name) {
    const auto found = frame.scalar.find(name);
    return found == frame.scalar.end() ? nullptr : &found->second;
}

}  // namespace

std::vector<FoamPoint> foam_points(const Frame& frame, float amount) {
    const std::vector<float>*foam = find_field(frame, "foam"), *airborne = find_field(frame, "airborne"),
          *grain = find_field(frame, "grain");
    if (!(amount > 0) || !foam || !airborne || !grain) return {};
    const int most = std::max(1, static_cast<int>(std::lround(amount * static_cast<float>(usual_points))));
    const float d = frame.spacing;
    const Cut cut(frame);
    const std::size_t each = static_cast<std::size_t>(most) + 1;
    std::vector<FoamPoint> points(foam->size() * each, FoamPoint{Vec3f::Zero(), Vec3f::Zero(), 0, 0});
    parallel_for(static_cast<Index>(foam->size()), [&](Index i) {
        const float f = std::clamp(((*foam)[i] - faint) / (1 - faint), 0.0f, 1.0f);
        FoamPoint* const own = &points[static_cast<std::size_t>(i) * each];
        const bool spray = (*airborne)[i] > spray_after;
        if (f > 0)
            own[most] = {frame.position[i],
                         frame.velocity[i],
                         mist_radius * d,
                         std::min(1.0f, amount) * f * (spray ? mist_of_spray : mist_opacity),
                         spray,
                         true};
        for (int k = 0; k < most; ++k) {
            // The points appear one after the other as f rises.
            const float opacity = std::clamp(8 * (f - (static_cast<float>(k) + 0.5f) / static_cast<float>(most)) + 0.5f, 0.0f, 1.0f);
            if (!(f > 0 && opacity > 0)) break;
            PointNumbers random((*grain)[i], k);
            const Vec3f off = scatter * d * random.in_ball(), drift = parting * frame.velocity[i].norm() * random.in_ball();
            FoamPoint& p = own[k];
            p.position = frame.position[i] + off + (*airborne)[i] * drift;
            p.velocity = frame.velocity[i];
            if (spray) p.velocity += drift, p.spray = true;
            const float size = random.next();
            p.radius = d * (0.022f + 0.045f * size * size);
            p.opacity = spray ? opacity : bubble_opacity * opacity;
            for (int corner = 0; corner < 3 && cut.any(); ++corner)  // a corner has three walls
                if (const Cut::Side side = cut.at(p.position); side.is_wall && side.inside(p.position) < p.radius)
                    p.position += (p.radius - side.inside(p.position)) * side.inward;
        }
    });
    std::erase_if(points, [](const FoamPoint& p) { return !(p.opacity > 0); });
    return points;
}

Frame without_spray(const Frame& frame) {
    const std::vector<float>* airborne = find_field(frame, "airborne");
    if (!airborne) return frame;
    const auto kept = [&](auto values) {
        std::size_t n = 0;
        for (std::size_t i = 0; i < values.size(); ++i)
            if (!((*airborne)[i] > spray_after)) values[n++] = values[i];
        values.resize(n);
        return values;
    };
    Frame part = frame;
    part.position = kept(frame.position), part.velocity = kept(frame.velocity);
    for (auto& [name, values] : part.scalar) values = kept(frame.scalar.at(name));
    for (auto& [name, values] : part.vector) values = kept(frame.vector.at(name));
    for (auto& [name, values] : part.whole) values = kept(frame.whole.at(name));
    return part;
}

Surface build_surface(const Frame& frame, const SurfaceOptions& options, float amount) {
    return amount > 0 ? build_surface(without_spray(frame), options) : build_surface(frame, options);
}

}  // namespace whorl
