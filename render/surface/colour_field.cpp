#include "render/surface/colour_field.h"

#include <algorithm>

#include "engine/core/parallel.h"

namespace whorl {
namespace {

// sum_k (1 - r_ik^2 / R^2)^3 over the particles of a run; written without a branch, so that the compiler vectorises it.
float kernel_sum(const ParticleRows& p, Index begin, Index end, float x, float y, float z, float inverse_R2) {
    float sum = 0;
    for (Index k = begin; k < end; ++k) {
        const float dx = p.x[k] - x, dy = p.y[k] - y, dz = p.z[k] - z;
        const float t = std::max(0.0f, 1 - inverse_R2 * (dx * dx + dy * dy + dz * dz));
        sum += t * t * t;
    }
    return sum;
}

}  // namespace

ColourField::ColourField(Span<const Vec3f> position, double spacing, double radius)
    : reach_(static_cast<float>(radius * spacing)), rows_(position, reach_), height_(rows_.x.size()) {
    const float inverse_R2 = 1 / (reach_ * reach_);
    parallel_for(rows_.size(), [&](Index i) {
        const Vec3f p(rows_.x[i], rows_.y[i], rows_.z[i]);
        float sum = 0;
        rows_.runs(p.array() - reach_, p.array() + reach_,
                   [&](Index begin, Index end) { sum += kernel_sum(rows_, begin, end, p.x(), p.y(), p.z(), inverse_R2); });
        height_[i] = 1 / sum;
    });
}

void LocalField::gather(const ColourField& field, const Vec3f& low, const Vec3f& high) {
    const ParticleRows& p = field.particles();
    reach = field.reach();
    const Vec3f from = low.array() - reach, to = high.array() + reach;
    x.clear(), y.clear(), z.clear(), height.clear(), original.clear();
    p.runs(from, to, [&](Index begin, Index end) {
        for (Index j = begin; j < end; ++j) {
            if (p.y[j] < from.y() || p.y[j] > to.y() || p.z[j] < from.z() || p.z[j] > to.z()) continue;
            x.push_back(p.x[j]);
            y.push_back(p.y[j]);
            z.push_back(p.z[j]);
            height.push_back(field.height()[j]);
            original.push_back(p.original[j]);
        }
    });
}

LocalField::Sample LocalField::at(const Vec3f& at) const {
    const float inverse_R2 = 1 / (reach * reach), ax = at.x(), ay = at.y(), az = at.z();
    float c = 0, gx = 0, gy = 0, gz = 0;
    const std::size_t n = x.size();
    for (std::size_t j = 0; j < n; ++j) {
        const float dx = ax - x[j], dy = ay - y[j], dz = az - z[j];
        const float t = std::max(0.0f, 1 - inverse_R2 * (dx * dx + dy * dy + dz * dz));
        const float slope = height[j] * t * t;  // grad (1 - r^2/R^2)^3 = -6/R^2 t^2 (x - x_j)
        c += slope * t;
        gx += slope * dx;
        gy += slope * dy;
        gz += slope * dz;
    }
    return {c, -6 * inverse_R2 * Vec3f(gx, gy, gz)};
}

}  // namespace whorl
