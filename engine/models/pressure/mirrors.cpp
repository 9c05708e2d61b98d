#include "engine/models/pressure/mirrors.h"

#include <algorithm>
#include <cmath>

#include "engine/core/parallel.h"

namespace whorl {
namespace {

/// x_i - x_j [m], to the nearest periodic image.
Vec3 apart(const Pairs& pairs, Index i, Index j) {
    Vec3 r = pairs.x_own[i] - pairs.x_other[j];
    for (int a = 0; a < 3; ++a)
        if (const Real length = pairs.period[a]; length > 0) r[a] -= length * std::nearbyint(r[a] / length);
    return r;
}

}  // namespace

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

void Mirrors::find_pairs(const FluidPairs& fluid) {
    constexpr Index block = 256;
    const Index n = fluid.size();
    std::vector<std::vector<std::pair<Index, Real>>> found(static_cast<std::size_t>((n + block - 1) / block));  // images and weights
    pairs_.period = fluid.period, pairs_.support = fluid.support;
    pairs_.first.assign(static_cast<std::size_t>(n) + 1, 0), pairs_.other.clear(), weight_.clear();
    if (images_.empty()) return;
    parallel_blocks(n, block, [&](Index begin, Index end) {
        auto& all = found[static_cast<std::size_t>(begin / block)];
        for (Index i = begin; i < end; ++i) {
            const Seen& seen = seen_[i];
            const auto add = [&](Index j) {
                for (Index g = first_[j]; g < first_[j + 1]; ++g) {
                    if (!(apart(pairs_, i, g).squaredNorm() < fluid.support * fluid.support)) continue;
                    const Image& image = images_[g];
                    bool known = true;
                    for (int m = 0; m < image.count; ++m) known &= seen.knows(image.wall[m].normal);
                    if (known) all.emplace_back(g, (part_[i] + part_[j]) / 2);
                }
            };
            if (seen.count > 0) {
                add(i);
                for (std::size_t k = fluid.first[i]; k < fluid.first[i + 1]; ++k) add(fluid.other[k]);
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
