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

Surroundings Mirrors::find(const Surroundings& around, bool none) {
    particles_ = around.pairs.size();
    images_.clear(), part_.clear();
    if (none || around.layer.flat.empty()) return around;
    const Column<Real> flat = flat_now(around);
    part_.assign(static_cast<std::size_t>(particles_), 0);
    seen_.resize(static_cast<std::size_t>(particles_));
    near_.resize(seen_.size());
    parallel_for(particles_, [&](Index i) {
        look(around, flat, i);
        near_[i] = seen_[i].own > 0;
    });
    parallel_for(particles_, [&](Index i) { ask_neighbours(around, i); });
    find_images();
    place(around.pairs.x_own);
    find_pairs(around);
    return seen(around);
}

/// SolidParticles::flat, less beside solids that move against it, and 0 on solids that turn.
Column<Real> Mirrors::flat_now(const Surroundings& around) {
    const SolidParticles& layer = around.layer;
    Column<Real> flat = layer.flat;
    if (!around.solids.any_moving()) return flat;
    parallel_for(layer.size(), [&](Index s) {
        const Solid& own = around.solids.all[layer.solid[s]];
        if (!own.pose.angular_velocity.isZero(0)) flat[s] = 0;
        for (const Solid& other : around.solids.all)
            if (&other != &own && flat[s] > 0 && (own.moves() || other.moves()))
                flat[s] = std::min(flat[s], flat_beside(other.distance(layer.position[s]), around.step.support));
    });
    return flat;
}

/// The walls that the solid neighbours of i belong to.
void Mirrors::look(const Surroundings& around, Span<const Real> flat, Index i) {
    const Real d = around.step.spacing, reach = around.step.support;
    Seen& seen = seen_[i];
    seen.own = seen.count = 0;
    Real all = 0, mirrors = 0, lowest = d;
    bool skew = false;
    around.solid_pairs.of(i, [&](Index s, const Vec3& r, Real distance) {
        if (flat[s] < 0 || !(distance < reach)) return;
        const Real weight = (reach - distance) * (reach - distance);
        all += weight, mirrors += flat[s] * weight;
        const Vec3& normal = around.layer.normal[s];
        const Real height = r.dot(normal) - d / 2;
        lowest = std::min(lowest, height);
        if (flat[s] == 0 || height < -d / 4 || seen.knows(normal)) return;
        for (int m = 0; m < seen.count; ++m) {
            const Real turn = normal.dot(seen.wall[m].normal);
            skew |= std::abs(turn) > Real(0.01) && turn > Real(-0.99);
        }
        if (seen.count == 3) skew = true;
        else seen.wall[seen.count++] = {normal, around.pairs.x_own[i].dot(normal) - height, around.layer.solid[s]};
    });
    if (skew || mirrors == 0) seen.count = 0;
    else part_[i] = mirrors / all * std::clamp(lowest / (d / 5) - Real(0.5), Real(0), Real(1));  // on the wall its own image pushes nothing
    seen.own = seen.count;
}

/// Adds walls that neighbours of i see, which are too far from i to have their solids as neighbours.
void Mirrors::ask_neighbours(const Surroundings& around, Index i) {
    Seen& seen = seen_[i];
    if (seen.own == 0 && around.solid_pairs.count(i) > 0) return;
    Real most = 0;
    for (std::size_t k = around.pairs.first[i]; k < around.pairs.first[i + 1]; ++k) {
        const Index j = around.pairs.other[k];
        if (!near_[j]) continue;
        for (int m = 0; m < seen_[j].own; ++m) {
            const Wall& wall = seen_[j].wall[m];
            if (seen.count == 3 || seen.knows(wall.normal)) continue;
            const Real height = wall.height(around.pairs.x_own[j]) + apart(around.pairs, i, j).dot(wall.normal);
            if (height < 0 || height > around.step.support) continue;
            seen.wall[seen.count++] = {wall.normal, around.pairs.x_own[i].dot(wall.normal) - height, wall.solid};
            most = std::max(most, part_[j]);
        }
    }
    if (seen.own == 0 && seen.count > 0) part_[i] = most;
}

void Mirrors::find_images() {
    first_.assign(static_cast<std::size_t>(particles_) + 1, 0);
    for (Index i = 0; i < particles_; ++i) {
        const Seen& seen = seen_[i];
        for (int m = 0; m < seen.count; ++m) {
            images_.push_back({i, 1, {seen.wall[m], {}}});
            for (int k = 0; k < m; ++k)
                if (std::abs(seen.wall[k].normal.dot(seen.wall[m].normal)) < Real(0.01))
                    images_.push_back({i, 2, {seen.wall[k], seen.wall[m]}});
        }
        first_[i + 1] = size();
    }
}

void Mirrors::place(Span<const Vec3> x) {
    if (part_.empty()) return;
    places_.resize(static_cast<std::size_t>(particles_ + size()));
    std::copy(x.begin(), x.end(), places_.begin());
    reflect(x.data(), places_.data() + x.size(), [](const Wall& wall) { return wall.offset; });
    pairs_.x_other = places_;
}

void Mirrors::find_pairs(const Surroundings& around) {
    const FluidPairs& fluid = around.pairs;
    const auto images_near = [&](Index i, const auto& f) {
        const Seen& seen = seen_[i];
        if (seen.count == 0) return;
        const auto of = [&](Index j) {
            for (Index g = first_[j]; g < first_[j + 1]; ++g) {
                const Image& image = images_[g];
                if (!seen.knows(image.wall[0].normal) || (image.count == 2 && !seen.knows(image.wall[1].normal))) continue;
                if (apart(pairs_, i, particles_ + g).squaredNorm() < fluid.support * fluid.support)
                    f(particles_ + g, (part_[i] + part_[j]) / 2);
            }
        };
        of(i);
        for (std::size_t k = fluid.first[i]; k < fluid.first[i + 1]; ++k) of(fluid.other[k]);
    };
    pairs_.x_own = fluid.x_own, pairs_.period = fluid.period, pairs_.support = fluid.support;
    pairs_.first.resize(fluid.first.size());
    parallel_for(particles_, [&](Index i) {
        std::size_t count = static_cast<std::size_t>(fluid.count(i));
        images_near(i, [&](Index, Real) { ++count; });
        pairs_.first[i + 1] = count;
    });
    for (Index i = 0; i < particles_; ++i) pairs_.first[i + 1] += pairs_.first[i];
    pairs_.other.resize(pairs_.first.back());
    weight_.assign(pairs_.first.back(), 1);
    weighted_.resize(seen_.size());
    parallel_for(particles_, [&](Index i) {
        std::size_t k = pairs_.first[i];
        std::copy(fluid.other.begin() + fluid.first[i], fluid.other.begin() + fluid.first[i + 1], pairs_.other.begin() + k);
        k += static_cast<std::size_t>(fluid.count(i));
        weighted_[i] = 0;
        images_near(i, [&](Index g, Real weight) { pairs_.other[k] = g, weight_[k++] = weight, weighted_[i] |= weight != 1; });
    });
}

}  // namespace whorl
