#include "render/surface/particle_rows.h"

#include <cmath>
#include <limits>

#include "engine/core/parallel.h"

namespace whorl {
namespace {

constexpr float furthest_row = 1e5f;  // beyond it floats cannot distinguish the nodes of the finest surface

}  // namespace

ParticleRows::ParticleRows(Span<const Vec3f> position, float width) : width_(width) {
    std::vector<Index> near;
    near.reserve(position.size());
    Vec3f low = Vec3f::Constant(std::numeric_limits<float>::max()), high = -low;
    const float furthest = furthest_row * width;
    for (std::size_t i = 0; i < position.size(); ++i)
        if ((position[i].array().abs() < furthest).all()) {
            near.push_back(static_cast<Index>(i));
            low = low.cwiseMin(position[i]);
            high = high.cwiseMax(position[i]);
        }
    if (near.empty()) return;

    // A stray particle far away must not need more rows than memory can store. Wider rows are slower but give the same result.
    origin_ = low;
    const auto rows_along = [&](int axis) { return std::floor(static_cast<double>(high[axis] - low[axis]) / width_) + 1; };
    while (rows_along(1) * rows_along(2) > 1e7) width_ *= 2;
    ny_ = static_cast<int>(rows_along(1));
    nz_ = static_cast<int>(rows_along(2));

    const std::size_t rows = static_cast<std::size_t>(ny_) * nz_;
    std::vector<Index> row(near.size());
    row_begin_.assign(rows + 1, 0);
    for (std::size_t n = 0; n < near.size(); ++n) {
        const Vec3f& p = position[near[n]];
        row[n] = std::min(row_of(p.z(), low.z()), nz_ - 1) * ny_ + std::min(row_of(p.y(), low.y()), ny_ - 1);
        ++row_begin_[row[n] + 1];
    }
    for (std::size_t r = 0; r < rows; ++r) row_begin_[r + 1] += row_begin_[r];

    original.resize(near.size());
    std::vector<Index> next(row_begin_.begin(), row_begin_.end() - 1);
    for (std::size_t n = 0; n < near.size(); ++n) original[next[row[n]]++] = near[n];
    parallel_tasks(static_cast<Index>(rows), [&](Index r) {
        std::sort(original.begin() + row_begin_[r], original.begin() + row_begin_[r + 1],
                  [&](Index a, Index b) { return position[a].x() != position[b].x() ? position[a].x() < position[b].x() : a < b; });
    });

    x.resize(near.size());
    y.resize(near.size());
    z.resize(near.size());
    parallel_for(size(), [&](Index i) {
        const Vec3f& p = position[original[i]];
        x[i] = p.x();
        y[i] = p.y();
        z[i] = p.z();
    });
}

std::vector<ParticleRows::Bunch> ParticleRows::bunches(float extent) const {
    std::vector<Bunch> all;
    for (Index i = 0; i < size(); ++i) {
        const Vec3f next(x[i], y[i], z[i]);
        if (!all.empty()) {
            Bunch& bunch = all.back();
            const Vec3f low = bunch.low.cwiseMin(next), high = bunch.high.cwiseMax(next);
            if ((high - low).maxCoeff() <= extent) {
                bunch = {bunch.begin, i + 1, low, high};
                continue;
            }
        }
        all.push_back({i, i + 1, next, next});
    }
    return all;
}

}  // namespace whorl
