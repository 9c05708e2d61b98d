#pragma once
/// Particles sorted for range queries: rows of square cross-section along x, each sorted by x.
#include <algorithm>
#include <vector>

#include "engine/core/types.h"

namespace whorl {

class ParticleRows {
public:
    /// @param width of a row [m]. Particles that are not finite, or farther than 1e5 widths from the origin, are left out.
    ParticleRows(Span<const Vec3f> position, float width);

    Index size() const { return static_cast<Index>(x.size()); }

    /// Calls f(begin, end) for runs of particles that together contain every particle of the box, in a fixed order.
    template <class F>
    void runs(const Vec3f& low, const Vec3f& high, F&& f) const {
        const int y0 = std::max(0, row_of(low.y(), origin_.y())), y1 = std::min(ny_ - 1, row_of(high.y(), origin_.y()));
        const int z0 = std::max(0, row_of(low.z(), origin_.z())), z1 = std::min(nz_ - 1, row_of(high.z(), origin_.z()));
        for (int iz = z0; iz <= z1; ++iz)
            for (int iy = y0; iy <= y1; ++iy) {
                const std::size_t row = static_cast<std::size_t>(iz) * ny_ + iy;
                const auto begin = x.begin() + row_begin_[row], end = x.begin() + row_begin_[row + 1];
                const auto first = std::lower_bound(begin, end, low.x()), last = std::upper_bound(first, end, high.x());
                if (first != last) f(static_cast<Index>(first - x.begin()), static_cast<Index>(last - x.begin()));
            }
    }

    /// Calls f(i, r) for each particle nearer to `place` than `reach` [m]; r: vector from `place` to the particle [m].
    template <class F>
    void near(const Vec3f& place, float reach, F&& f) const {
        runs(place.array() - reach, place.array() + reach, [&](Index begin, Index end) {
            for (Index i = begin; i < end; ++i)
                if (const Vec3f r = at(i) - place; r.squaredNorm() < reach * reach) f(i, r);
        });
    }
    Vec3f at(Index i) const { return {x[i], y[i], z[i]}; }

    /// A run of consecutive particles that are close together.
    struct Bunch {
        Index begin, end;
        Vec3f low, high;  ///< bounding box
    };
    /// All particles, in bunches whose boxes are at most `extent` [m] long along each axis: a bunch needs one range query for all its
    /// particles.
    std::vector<Bunch> bunches(float extent) const;

    std::vector<float> x, y, z;   ///< m, sorted
    std::vector<Index> original;  ///< the particle's index in the frame

private:
    int row_of(float value, float origin) const { return static_cast<int>(std::floor(std::clamp((value - origin) / width_, -1.0f, 1e6f))); }

    Vec3f origin_ = Vec3f::Zero();
    float width_;
    int ny_ = 0, nz_ = 0;
    std::vector<Index> row_begin_;
};

}  // namespace whorl
