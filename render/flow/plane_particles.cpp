#include "render/flow/plane_particles.h"

#include <algorithm>
#include <cmath>

namespace whorl {

PlaneParticles::PlaneParticles(const Frame& frame, const PixelPlane& plane, float how_far) : reach(how_far) {
    const Vec3f period = frame.domain_max - frame.domain_min, normal = plane.normal();
    const float wide = plane.pixel * static_cast<float>(plane.width), tall = plane.pixel * static_cast<float>(plane.height);
    margin_ = 2 * reach, cell_ = std::max(reach, plane.pixel);
    across_ = static_cast<int>((wide + 2 * margin_) / cell_) + 1, rows_ = static_cast<int>((tall + 2 * margin_) / cell_) + 1;

    std::array<int, 3> images{};
    for (int a = 0; a < 3; ++a) images[a] = frame.periodic[a] && !(a == 2 && frame.dimensions == 2) ? 1 : 0;
    std::vector<Vec3f> found;
    std::vector<std::uint32_t> whose, cell;
    for (std::size_t p = 0; p < frame.position.size(); ++p)
        for (int i = -images[0]; i <= images[0]; ++i)
            for (int j = -images[1]; j <= images[1]; ++j)
                for (int k = -images[2]; k <= images[2]; ++k) {
                    const Vec3f r = frame.position[p] +
                                    period.cwiseProduct(Vec3f(static_cast<float>(i), static_cast<float>(j), static_cast<float>(k))) -
                                    plane.corner;
                    const Vec3f x(r.dot(plane.right), r.dot(plane.up), r.dot(normal));
                    const bool near = x.x() > -margin_ && x.x() < wide + margin_ && x.y() > -margin_ && x.y() < tall + margin_ &&
                                      std::abs(x.z()) < margin_;
                    if (!near) continue;  // nor is what is not finite
                    found.push_back(x);
                    whose.push_back(static_cast<std::uint32_t>(p));
                    cell.push_back(static_cast<std::uint32_t>(row(x.y()) * across_ + column(x.x())));
                }
    first_.assign(static_cast<std::size_t>(across_) * static_cast<std::size_t>(rows_) + 1, 0);
    for (const std::uint32_t c : cell) ++first_[c + 1];
    for (std::size_t c = 1; c < first_.size(); ++c) first_[c] += first_[c - 1];
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    at.resize(found.size()), particle.resize(found.size());
    for (std::size_t i = 0; i < found.size(); ++i) {
        const std::uint32_t to = next[cell[i]]++;
        at[to] = found[i], particle[to] = whose[i];
    }
}

}  // namespace whorl
