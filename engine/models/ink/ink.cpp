#include <algorithm>
#include <cmath>

#include "engine/core/parallel.h"
#include "engine/models/ink/ink_markers.h"
#include "engine/models/pressure/projection/difference_sums.h"
#include "engine/models/viscosity/explicit_viscosity.h"
#include "engine/sph/laplacian_moment.h"

namespace whorl {

void InkDiffusion::operator()(const InteractionContext& context, Write<field::ink_change> change, Update<field::ink> c) const {
    const StepContext& step = context.step;
    const double longest = viscous_step(static_cast<double>(step.support), diffusion);
    const int parts = std::max(1, static_cast<int>(std::ceil(static_cast<double>(step.dt) / longest)));
    const Real share = static_cast<Real>(diffusion) * step.dt / static_cast<Real>(parts), V = step.volume;
    std::vector<Real> n(c.size());
    with_kernel(step.kernel, step.support, [&](const auto& W) {
        parallel_for(c.size(), [&](Index i) { n[i] = laplacian_factor(laplacian_moment(W, context.pairs, i, V), step.dimensions()); });
        for (int part = 0; part < parts; ++part) {
            parallel_for(c.size(), [&](Index i) {
                Real sum[3] = {0, 0, 0};
                const Vec3 own = c[i];
                const Real of_own = n[i];
                context.pairs.groups_of(i, [&](const Pairs::Group& group) {
                    Real other[3][Pairs::Group::most], of_other[Pairs::Group::most];
                    group.gather(c.data(), other), group.gather(n.data(), of_other);
                    for (Index l = 0; l < group.padded(); ++l) {
                        const Real F = W.slope(group.distance[l]) * (of_own + of_other[l]);
                        for (int a = 0; a < 3; ++a) sum[a] -= F * (other[a][l] - own[a]);
                    }
                });
                change[i] = share * V * Vec3(sum[0], sum[1], sum[2]);
            });
            parallel_for(c.size(), [&](Index i) { c[i] += change[i]; });
        }
    });
}

void InkSources::operator()(const StepContext& step, Read<field::position> x, Update<field::ink> c, InkMarkers& markers) {
    const auto colour = [&](InkSource& source, Span<const Vec3> position, Span<Vec3> inks) {
        std::vector<Index> inside;
        std::vector<Vec3> place;
        for (Index i = 0; i < static_cast<Index>(position.size()); ++i)
            if (Vec3 at = position[i]; step.domain.image_in_box(at, source.min, source.max))
                inside.push_back(i), place.push_back(position[i]);
        source.ink.each(step.time, place, [&](Index k, const Vec3& ink) { inks[inside[k]] = ink.cwiseMax(Real(0)).cwiseMin(Real(1)); });
    };
    for (InkSource& source : sources) {
        colour(source, x.values, c.values);
        if (markers.per_spacing > 0) colour(source, markers.store.column<field::position>(), markers.store.column<field::ink>());
    }
}

namespace {

struct InkRange {
    Vec3 least, most;
};

/// Whether i and all its neighbours have the same ink.
bool alike_around(const FluidPairs& pairs, Index i, const Vec3* c) {
    const Vec3 own = c[i];
    for (std::size_t k = pairs.first[i]; k < pairs.first[i + 1]; ++k)
        if (c[pairs.other[k]] != own) return false;
    return true;
}

/// Range of ink over particle i and its neighbours within `reach`.
InkRange range_around(const FluidPairs& pairs, Index i, Real reach, const Vec3* c) {
    InkRange range{c[i], c[i]};
    pairs.groups_of(i, [&](const Pairs::Group& group) {
        Real other[3][Pairs::Group::most];
        group.gather(c, other);
        for (int a = 0; a < 3; ++a) {
            const Real own = c[i][a];
            Real least = own, most = own;
#pragma omp simd reduction(min : least) reduction(max : most)
            for (Index l = 0; l < group.padded(); ++l) {
                const Real v = group.distance[l] < reach ? other[a][l] : own;
                least = std::min(least, v), most = std::max(most, v);
            }
            range.least[a] = std::min(range.least[a], least), range.most[a] = std::max(range.most[a], most);
        }
    });
    return range;
}

}  // namespace

void CarryInk::operator()(const InteractionContext& context, Write<field::ink_change> change, Update<field::ink> c) const {
    const ProjectionSystem& s = *system;
    const StepContext& step = context.step;
    with_kernel(step.kernel, step.support, [&](const auto& W) {
        parallel_for(c.size(), [&](Index i) {
            change[i].setZero();
            if (s.shift[i] == Vec3::Zero() || alike_around(context.pairs, i, c.data())) return;
            const auto [least, most] = range_around(context.pairs, i, 2 * step.spacing, c.data());
            if ((most - least).maxCoeff() < Real(1e-6)) return;  // images resolve 1/255
            const Vec3 there = c[i] + carried(W, s.whole, context.pairs, i, step.volume, c.data(), s.shift[i]);
            change[i] = there.cwiseMax(least).cwiseMin(most) - c[i];
        });
    });
    parallel_for(c.size(), [&](Index i) { c[i] += change[i]; });
}

}  // namespace whorl
