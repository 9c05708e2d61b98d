#include "render/surface/colour_field.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/core/parallel.h"

namespace whorl {
namespace {

// Copy of the particles that a bunch reaches.
struct Around {
    std::vector<float> x, y, z;

    void gather(const ParticleRows& p, const Vec3f& low, const Vec3f& high) {
        for (std::vector<float>* v : {&x, &y, &z}) v->clear();
        p.runs(low, high, [&](Index begin, Index end) {
            x.insert(x.end(), p.x.begin() + begin, p.x.begin() + end);
            y.insert(y.end(), p.y.begin() + begin, p.y.begin() + end);
            z.insert(z.end(), p.z.begin() + begin, p.z.begin() + end);
        });
    }
    // sum_k (1 - r_ik^2 / R^2)^3 for two R in one loop, written without a branch so that the compiler vectorises it.
    std::array<float, 2> sums(const Vec3f& at, float first_R, float second_R) const {
        const float first_inverse = 1 / (first_R * first_R), second_inverse = 1 / (second_R * second_R);
        const float ax = at.x(), ay = at.y(), az = at.z();
        float first = 0, second = 0;
        const std::size_t n = x.size();
        for (std::size_t k = 0; k < n; ++k) {
            const float dx = x[k] - ax, dy = y[k] - ay, dz = z[k] - az, r2 = dx * dx + dy * dy + dz * dz;
            const float t = std::max(0.0f, 1 - first_inverse * r2), u = std::max(0.0f, 1 - second_inverse * r2);
            first += t * t * t;
            second += u * u * u;
        }
        return {first, second};
    }
};

// (Kernel radius of a lone particle)/(the usual radius). With a smaller `few`, droplets of a few particles come out too thick; with a
// larger one, threads of radius 3 d that are 1 d apart merge.
constexpr float lone_factor = 1.2f;
// Sum of the wide kernels about a particle: below `few` the particle's own kernel is wide, above `many` it is not. The sum is 8.8 inside a
// fluid, 5.3 at a flat surface and 2.2 in a single file.
constexpr float few = 3.0f, many = 4.7f;

// A lone particle with its wide kernel is a drop of 1.8 d^3, but spray is finer than the spacing. So the kernel shrinks with the distance
// to the nearest other particle, from a factor of 1 at `apart` kernel radii to `spray_factor` at `alone` kernel radii. This gives a drop of
// 0.6 d^3 after the smoothing of the mesh. A particle nearer than `apart` may belong to a thread.
constexpr float apart = 1.04f, alone = 1.9f, spray_factor = 0.85f;

// Distance to the nearest other particle, at most `most`.
float nearest_other(const ParticleRows& p, Index i, float most) {
    float nearest2 = most * most;
    p.near(p.at(i), most, [&](Index k, const Vec3f& r) {
        if (k != i) nearest2 = std::min(nearest2, r.squaredNorm());
    });
    return std::sqrt(nearest2);
}

}  // namespace

ColourField::ColourField(Span<const Vec3f> position, double spacing, double radius)
    : reach_(static_cast<float>(lone_factor * radius * spacing)), rows_(position, reach_), height_(rows_.x.size()),
      radius_(rows_.x.size()) {
    const std::vector<ParticleRows::Bunch> bunches = rows_.bunches(reach_);
    parallel_tasks(static_cast<Index>(bunches.size()), [&](Index n) {
        thread_local Around around;
        const ParticleRows::Bunch& bunch = bunches[n];
        around.gather(rows_, bunch.low.array() - reach_, bunch.high.array() + reach_);
        for (Index i = bunch.begin; i < bunch.end; ++i) {
            const Vec3f p = rows_.at(i);
            const float usual = reach_ / lone_factor;
            const auto [company, usual_sum] = around.sums(p, reach_, usual);
            const float s = std::clamp((many - company) / (many - few), 0.0f, 1.0f);
            radius_[i] = s > 0 ? reach_ * (1 + s * s * (3 - 2 * s) * (lone_factor - 1)) / lone_factor : usual;
            if (company < 1.001f) {
                const float away = (nearest_other(rows_, i, alone * reach_) / reach_ - apart) / (alone - apart);
                radius_[i] *= 1 - (1 - spray_factor) * std::clamp(away, 0.0f, 1.0f);
            }
            height_[i] = 1 / (s > 0 ? around.sums(p, radius_[i], radius_[i])[0] : usual_sum);
        }
    });
}

void LocalField::gather(const ColourField& field, const Vec3f& low, const Vec3f& high, bool at_glass) {
    const ParticleRows& p = field.particles();
    reach = field.reach();
    const float margin = reach + (at_glass ? 1.5f * wetting() : 0);
    const Vec3f from = low.array() - margin, to = high.array() + margin;
    x.clear(), y.clear(), z.clear(), height.clear(), inverse_R2.clear();
    p.runs(from, to, [&](Index begin, Index end) {
        for (Index j = begin; j < end; ++j) {
            if (p.y[j] < from.y() || p.y[j] > to.y() || p.z[j] < from.z() || p.z[j] > to.z()) continue;
            x.push_back(p.x[j]);
            y.push_back(p.y[j]);
            z.push_back(p.z[j]);
            height.push_back(field.height()[j]);
            inverse_R2.push_back(1 / (field.radius()[j] * field.radius()[j]));
        }
    });
}

LocalField::Sample LocalField::at(const Vec3f& at) const {
    const float ax = at.x(), ay = at.y(), az = at.z();
    float c = 0, gx = 0, gy = 0, gz = 0, company = 0;
    const float widest_inverse = 1 / (reach * reach);
    const std::size_t n = x.size();
    for (std::size_t j = 0; j < n; ++j) {
        const float dx = ax - x[j], dy = ay - y[j], dz = az - z[j], r2 = dx * dx + dy * dy + dz * dz;
        const float t = std::max(0.0f, 1 - inverse_R2[j] * r2), bump = height[j] * t * t, wide = std::max(0.0f, 1 - widest_inverse * r2);
        const float slope = bump * inverse_R2[j];  // grad (1 - r^2/R^2)^3 = -6/R^2 t^2 (x - x_j)
        c += bump * t;
        company += wide * wide * wide;
        gx += slope * dx;
        gy += slope * dy;
        gz += slope * dz;
    }
    return {c, -6 * Vec3f(gx, gy, gz), company};
}

LocalField::Sample LocalField::at(const Vec3f& here, const Cut& near, float iso) const {
    Sample sample = at(here);
    if (!near.any()) return sample;
    if (near.any_glass()) {
        const Vec3f away = near.off_glass(here, wetting()), way = away - here;
        if (way.squaredNorm() > 0) {
            Sample wet = at(away);
            wet.gradient -= wet.gradient.dot(way) / way.squaredNorm() * way;
            if (wet.colour > sample.colour) sample = wet;
        }
    }
    const Cut::Side side = near.at(here);
    const float most = cut_colour(side.inside(here), iso, reach);
    if (most < sample.colour) sample = {most, side.inward / reach, sample.company};
    return sample;
}

}  // namespace whorl
