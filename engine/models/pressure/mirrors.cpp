#include "engine/models/pressure/mirrors.h"

#include <algorithm>
#include <cmath>

#include "engine/core/parallel.h"

namespace whorl {

void Mirrors::find(const InteractionContext& context, bool none) {
    images_.clear(), part_.clear();
    if (none || context.boundary.flat.empty()) return;
    const Column<Real> flat = flat_now(context);
    const Index n = context.pairs.size();
    part_.assign(static_cast<std::size_t>(n), 0);
    seen_.resize(part_.size());
    parallel_for(n, [&](Index i) { look(context, flat, i); });
    find_images(n);
    place(context.pairs.x_own);
    find_pairs(context.pairs);
}

/// BoundaryParticles::flat, reduced near solids that move relative to the wall; 0 on solids that turn.
Column<Real> Mirrors::flat_now(const InteractionContext& context) {
    const BoundaryParticles& boundary = context.boundary;
    Column<Real> flat = boundary.flat;
    if (!context.solids.any_moving()) return flat;
    parallel_for(boundary.size(), [&](Index s) {
        const Solid& own = context.solids.all[boundary.solid[s]];
        if (!own.pose.angular_velocity.isZero(0)) flat[s] = 0;
        for (const Solid& other : context.solids.all)
            if (&other != &own && flat[s] > 0 && (own.moves() || other.moves()))
                flat[s] = std::min(flat[s], flat_beside(other.distance(boundary.position[s]), context.step.support));
    });
    return flat;
}

/// Finds the walls that the solid neighbours of i belong to.
void Mirrors::look(const InteractionContext& context, Span<const Real> flat, Index i) {
    const Real d = context.step.spacing, reach = context.step.support;
    Seen& seen = seen_[i];
    seen.count = 0;
    if (context.solid_pairs.count(i) == 0) return;
    Real all = 0, mirrors = 0, lowest = d;
    bool skew = false;
    context.solid_pairs.of(i, [&](Index s, const Vec3& r, Real distance) {
        if (flat[s] < 0 || !(distance < reach)) return;
        const Vec3& normal = context.boundary.normal[s];
        const Real height = r.dot(normal) - d / 2;
        if (height < d / 2 - reach) return;  // i is on the far side of a wall; the fluid at s is out of reach
        const Real weight = (reach - distance) * (reach - distance);
        all += weight, mirrors += flat[s] * weight;
        lowest = std::min(lowest, height);
        if (flat[s] == 0 || height < -d / 4 || seen.knows(normal)) return;
        for (int m = 0; m < seen.count; ++m) {
            const Real turn = normal.dot(seen.wall[m].normal);
            skew |= std::abs(turn) > Real(0.01) && turn > Real(-0.99);
        }
        if (seen.count == 3) skew = true;
        else seen.wall[seen.count++] = {normal, context.pairs.x_own[i].dot(normal) - height, context.boundary.solid[s]};
    });
    if (skew || mirrors == 0) seen.count = 0;
    else part_[i] = mirrors / all * std::clamp(lowest / (d / 5) - Real(0.5), Real(0), Real(1));  // 0 on the wall: no push by its own image
}

void Mirrors::find_images(Index particles) {
    first_.assign(static_cast<std::size_t>(particles) + 1, 0);
    for (Index i = 0; i < particles; ++i) {
        const Seen& seen = seen_[i];
        for (int walls = 1; walls < 1 << seen.count; ++walls) {  // each set of walls at right angles
            Image image{i, 0, {}};
            bool upright = true;
            for (int m = 0; m < seen.count; ++m) {
                if (!(walls >> m & 1)) continue;
                for (int k = 0; k < image.count; ++k) upright &= std::abs(image.wall[k].normal.dot(seen.wall[m].normal)) < Real(0.01);
                image.wall[image.count++] = seen.wall[m];
            }
            if (upright) images_.push_back(image);
        }
        first_[i + 1] = size();
    }
}

void Mirrors::place(Span<const Vec3> x) {
    places_.resize(images_.size());
    reflect(x.data(), places_.data(), [](const Wall& wall) { return wall.offset; });
    pairs_.x_own = x, pairs_.x_other = places_;
}

/// Lists the images of i and of its neighbours that are within the support of i. The loops avoid branches, which the processor could not
/// predict.
/// @returns their number; `list` is longer
std::size_t Mirrors::list_images_near(const FluidPairs& fluid, Index i, std::vector<Index>& list) const {
    constexpr Index most_of_one = 8;  // three walls make seven images
    std::size_t all = 0, near = 0;
    list.resize((static_cast<std::size_t>(fluid.count(i)) + 1) * most_of_one + most_lanes);
    const auto add = [&](Index j) {
        const Index first = first_[j], count = first_[j + 1] - first;
        for (Index g = 0; g < most_of_one; ++g) list[all + g] = first + g;
        all += static_cast<std::size_t>(count);
    };
    add(i);
    for (std::size_t k = fluid.first[i]; k < fluid.first[i + 1]; ++k) add(fluid.other[k]);
    std::fill_n(list.begin() + static_cast<std::ptrdiff_t>(all), all > 0 ? most_lanes : 0, list[0]);
    const Vec3 x = pairs_.x_own[i];
    for (std::size_t k = 0; k < all; k += most_lanes) {
        Real r[3][most_lanes], square[most_lanes] = {};
        gather(places_.data(), &list[k], most_lanes, r);
        for (int a = 0; a < 3; ++a) {
            const Real length = pairs_.period[a], inverse = length > 0 ? 1 / length : 0;
            for (Index l = 0; l < most_lanes; ++l) {
                Real apart = x[a] - r[a][l];
                apart -= length * std::nearbyint(apart * inverse);
                square[l] += apart * apart;
            }
        }
        const auto here = static_cast<Index>(std::min<std::size_t>(most_lanes, all - k));
        for (Index l = 0; l < here; ++l) {  // near <= k + l
            list[near] = list[k + l];
            near += square[l] < fluid.support * fluid.support;
        }
    }
    return near;
}

void Mirrors::find_pairs(const FluidPairs& fluid) {
    constexpr Index block = 256;
    const Index n = fluid.size();
    std::vector<std::vector<std::pair<Index, Real>>> found(static_cast<std::size_t>((n + block - 1) / block));  // images and weights
    pairs_.period = fluid.period, pairs_.support = fluid.support;
    pairs_.first.assign(static_cast<std::size_t>(n) + 1, 0), pairs_.other.clear(), weight_.clear();
    if (images_.empty()) return;
    parallel_blocks(n, block, [&](Index begin, Index end) {
        auto& all = found[static_cast<std::size_t>(begin / block)];
        std::vector<Index> images;
        for (Index i = begin; i < end; ++i) {
            const Seen& seen = seen_[i];
            if (seen.count > 0) {
                const std::size_t near = list_images_near(fluid, i, images);
                for (std::size_t k = 0; k < near; ++k) {
                    const Image& image = images_[images[k]];
                    bool known = true;
                    for (int m = 0; m < image.count; ++m) known &= seen.knows(image.wall[m].normal);
                    if (known) all.emplace_back(images[k], (part_[i] + part_[image.owner]) / 2);
                }
            }
            pairs_.first[i + 1] = all.size();
        }
    });
    for (Index begin = 0; begin < n; begin += block) {
        const std::size_t shift = pairs_.other.size();
        for (const auto& [g, weight] : found[static_cast<std::size_t>(begin / block)]) pairs_.other.push_back(g), weight_.push_back(weight);
        for (Index i = begin; i < std::min(n, begin + block); ++i) pairs_.first[i + 1] += shift;
    }
    weight_.resize(weight_.size() + most_lanes);
}

}  // namespace whorl
