#pragma once
/// The particles near a plane, in its own axes, sorted so that those near a place are found at once.
#include <vector>

#include "engine/io/frame.h"
#include "render/flow/plane_field.h"

namespace whorl {

struct PlaneParticles {
    /// Those within `reach` [m] of the rectangle and of the plane; of a periodic flow also their images there.
    PlaneParticles(const Frame& frame, const PixelPlane& plane, float reach);

    std::vector<Vec3f> at;                ///< m from the corner, along right, up and the normal
    std::vector<std::uint32_t> particle;  ///< its number in the frame
    float reach = 0;                      ///< m

    /// Calls f(i) for all in cells that touch the rectangle, in an order that only the frame decides.
    template <class F>
    void within(float x0, float y0, float x1, float y1, const F& f) const {
        const int a = column(x0), b = column(x1), c = row(y0), d = row(y1);
        for (int y = c; y <= d; ++y)
            for (std::uint32_t i = first_[y * across_ + a]; i < first_[y * across_ + b + 1]; ++i) f(i);
    }
    template <class F>
    void around(const Eigen::Vector2f& x, float distance, const F& f) const {
        within(x.x() - distance, x.y() - distance, x.x() + distance, x.y() + distance, f);
    }

private:
    int column(float x) const { return std::clamp(static_cast<int>((x + margin_) / cell_), 0, across_ - 1); }
    int row(float y) const { return std::clamp(static_cast<int>((y + margin_) / cell_), 0, rows_ - 1); }
    float margin_ = 0, cell_ = 0;
    int across_ = 0, rows_ = 0;
    std::vector<std::uint32_t> first_;
};

}  // namespace whorl
