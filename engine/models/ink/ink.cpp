#include "engine/models/ink/ink.h"

#include <algorithm>
#include <cmath>

#include "engine/core/parallel.h"
#include "engine/models/viscosity/explicit_viscosity.h"

namespace whorl {

void InkDiffusion::operator()(const Surroundings& around, Write<field::ink_change> change, Update<field::ink> c) const {
    const StepContext& step = around.step;
    const double longest = viscous_step(static_cast<double>(step.support), diffusion);
    const int parts = std::max(1, static_cast<int>(std::ceil(static_cast<double>(step.dt) / longest)));
    const Real share = static_cast<Real>(diffusion) * step.dt / static_cast<Real>(parts), V = step.volume;
    std::vector<Real> n(c.size());
    with_kernel(step.kernel, step.support, [&](const auto& W) {
        parallel_for(c.size(), [&](Index i) {
            Real moment = 0;
            around.pairs.of(i, [&](Index, const Vec3&, Real r) { moment -= V * W.slope(r) * r * r; });
            // A particle that is all but alone has nearly no moment: it must not give more than it has.
            n[i] = static_cast<Real>(step.dimensions()) / std::max(moment, Real(0.5));
        });
        for (int part = 0; part < parts; ++part) {
            parallel_for(c.size(), [&](Index i) {
                Vec3 sum = Vec3::Zero();
                around.pairs.of(i, [&](Index j, const Vec3&, Real r) { sum -= W.slope(r) * (n[i] + n[j]) * (c[j] - c[i]); });
                change[i] = share * V * sum;
            });
            parallel_for(c.size(), [&](Index i) { c[i] += change[i]; });
        }
    });
}

void InkSources::operator()(const StepContext& step, Read<field::position> x, Update<field::ink> c) {
    for (InkSource& source : sources) {
        std::vector<Index> inside;
        std::vector<Vec3> place;
        for (Index i = 0; i < x.size(); ++i)
            if ((x[i].array() >= source.min.array()).all() && (x[i].array() <= source.max.array()).all())
                inside.push_back(i), place.push_back(x[i]);
        source.ink.each(step.time, place, [&](Index k, const Vec3& ink) { c[inside[k]] = ink.cwiseMax(Real(0)).cwiseMin(Real(1)); });
    }
}

namespace {

struct InkRange {
    Vec3 least, most;
};

/// Of particle i and its neighbours within `reach`.
InkRange range_around(const FluidPairs& pairs, Index i, Real reach, const Vec3* c) {
    Real low[3][lanes], high[3][lanes];  // side by side, as the loop over neighbours runs
    for (int a = 0; a < 3; ++a) std::fill_n(low[a], lanes, c[i][a]), std::fill_n(high[a], lanes, c[i][a]);
    pairs.groups_of(i, [&](const Pairs::Group& group) {
        Real other[3][Pairs::Group::most];
        group.gather(c, other);
        for (int a = 0; a < 3; ++a)
            for (Index from = 0; from < group.padded(); from += lanes)
                for (Index l = 0; l < lanes; ++l) {
                    const Real v = group.distance[from + l] < reach ? other[a][from + l] : c[i][a];
                    low[a][l] = v < low[a][l] ? v : low[a][l], high[a][l] = v > high[a][l] ? v : high[a][l];
                }
    });
    InkRange range;
    for (int a = 0; a < 3; ++a)
        range.least[a] = *std::min_element(low[a], low[a] + lanes), range.most[a] = *std::max_element(high[a], high[a] + lanes);
    return range;
}

}  // namespace

void CarryInk::operator()(const Surroundings& around, Write<field::ink_change> change, Update<field::ink> c) const {
    const ProjectionSystem& s = *system;
    const StepContext& step = around.step;
    with_kernel(step.kernel, viscous_support * step.support, [&](const auto& W) {
        parallel_for(c.size(), [&](Index i) {
            change[i].setZero();
            if (s.shift[i] == Vec3::Zero()) return;
            const auto [least, most] = range_around(around.pairs, i, 2 * step.spacing, c.data());
            if (least == most) return;
            const Vec3 there = c[i] + carried(W, s.viscous, around.pairs, i, step.volume, c.data(), s.shift[i]);
            change[i] = there.cwiseMax(least).cwiseMin(most) - c[i];
        });
    });
    parallel_for(c.size(), [&](Index i) { c[i] += change[i]; });
}

}  // namespace whorl
