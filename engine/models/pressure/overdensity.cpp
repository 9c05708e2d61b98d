#include "engine/models/pressure/overdensity.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "engine/core/parallel.h"
#include "engine/models/pressure/constraint.h"

namespace whorl {
namespace {

constexpr int most_sweeps = 100;

}  // namespace

void RelaxOverdensity::Scratch::with_neighbours(const Pairs& pairs, const std::vector<Index>& from, std::vector<Index>& all) {
    ++lists;
    all.clear();
    const auto take = [&](Index i) {
        if (seen[i] == lists) return;
        seen[i] = lists;
        all.push_back(i);
    };
    for (const Index i : from) {
        take(i);
        for (std::size_t k = pairs.first[i]; k < pairs.first[i + 1]; ++k) take(pairs.other[k]);
    }
}

template <class Kernel>
std::string RelaxOverdensity::relieve(const WallImage& wall, const Kernel& W, const InteractionContext& context, Read<field::role> role,
                                      Span<Real> rho, Span<Vec3> x, Span<Vec3> u, const std::function<void()>& find) const {
    Mirrors mirrors;
    const bool gated = wall.gate.threshold > 0;
    mirrors.find(context, gated);
    const StepContext& step = context.step;
    const Real rho_0 = step.rest_density, m = step.mass, crowded = rho_0 * (1 + most_ / 2), too_dense = rho_0 * (1 + Real(0.9) * most_),
               farthest = step.spacing / 5;
    const auto row = [&](Index i) {
        return density_row(
            wall, W, context, mirrors, i, []<bool>(const Pairs::Group&, const Real*) {},
            [](Index, const Vec3&, const WallImage::Share&) {});
    };
    const Index n = static_cast<Index>(x.size());
    Scratch of(n);
    const auto density = [&](Index i) { return density_at(wall, W, context, mirrors, i); };
    parallel_for(n, [&](Index i) { rho[i] = density(i); });
    const auto densest = [&] {  // (largest density)/rho_0 - 1
        const auto denser = [&](Index a, Index b) { return rho[a] < rho[b]; };
        return static_cast<double>(rho[*std::max_element(of.dense.begin(), of.dense.end(), denser)] / rho_0) - 1;
    };
    Real moved = 0;  // bound for the displacements since the neighbours were found
    for (int sweep = 0;; ++sweep) {
        of.dense.clear();
        const auto beside_light_body = [&](Index i) {  // the body would have to give way
            bool near_light = false;
            if (!wall.constant_when_near.empty())
                context.solid_pairs.of(
                    i, [&](Index s, const Vec3&, Real) { near_light |= wall.constant_when_near[context.boundary.solid[s]] != 0; });
            return near_light;
        };
        const auto look = [&](Index i) {
            if (rho[i] > too_dense && role[i] == 0 && !beside_light_body(i)) of.dense.push_back(i);
        };
        if (sweep == 0)
            for (Index i = 0; i < n; ++i) look(i);
        else
            for (const Index i : of.touched) look(i);
        if (of.dense.empty()) return "";
        if (sweep == most_sweeps)
            return fmt::format("{} particles are still crowded, one by {:.2g} %, after {} sweeps", of.dense.size(), 100 * densest(), sweep);
        of.with_neighbours(context.pairs, of.dense, of.crowded);
        std::erase_if(of.crowded, [&](Index i) { return !(rho[i] > crowded) || role[i] != 0; });
        parallel_for(static_cast<Index>(of.crowded.size()), [&](Index c) {
            const Index i = of.crowded[c];
            const DensityRow at_i = row(i);
            const Real diagonal = at_i.own.squaredNorm() + at_i.fill * at_i.fill * at_i.squares;
            const Real l = diagonal > std::numeric_limits<Real>::min() ? std::min(at_i.density - rho_0, rho_0 / 5) / (2 * diagonal) : 0;
            of.push[i] = l * at_i.own;
            of.share[i] = l * at_i.fill;
        });
        of.with_neighbours(context.pairs, of.crowded, of.movers);
        of.moves.resize(of.movers.size()), of.kicks.resize(of.movers.size());
        parallel_for(static_cast<Index>(of.movers.size()), [&](Index c) {
            const Index i = of.movers[c];
            Vec3 move = of.share[i] > 0 ? of.push[i] : Vec3(Vec3::Zero()), slower = Vec3::Zero();
            context.pairs.of(i, [&](Index j, const Vec3& r, Real distance) {
                const Real its = of.share[j], both = of.share[i] + its;
                if (!(both > 0)) return;
                const Real slope = m * W.slope(distance);
                move += its * slope * r;
                const Vec3 apart = u[i] - u[j];
                slower += both * slope * (apart - apart.dot(r) / std::max(r.squaredNorm(), std::numeric_limits<Real>::min()) * r);
            });
            mirrors.of(i, [&](Index g, const Vec3& r, Real distance, Real weight) {
                move += of.share[mirrors.owner(g)] * weight * m * W.slope(distance) * r;  // images receive no reaction
            });
            of.kicks[c] = role[i] != 0 ? Vec3(Vec3::Zero()) : slower;
            const Real length = move.norm();
            of.moves[c] = role[i] != 0 ? Vec3(Vec3::Zero()) : length > farthest ? Vec3(farthest / length * move) : move;
        });
        parallel_for(static_cast<Index>(of.movers.size()), [&](Index c) {
            const Index i = of.movers[c];
            of.share[i] = 0;
            const Vec3 before = x[i];
            x[i] -= of.moves[c];
            u[i] += of.kicks[c];
            Real distance = 0;
            if (role[i] != 0) return;  // a nozzle may be in a solid
            if (const int k = context.solids.nearest(x[i], distance); k >= 0 && distance < 0)
                x[i] -= distance * context.solids.all[k].normal(x[i]);
            of.moves[c] = x[i] - before;
        });
        moved += static_cast<Real>(std::sqrt(parallel_max(static_cast<Index>(of.movers.size()), 0,
                                                          [&](Index c) { return static_cast<double>(of.moves[c].squaredNorm()); })));
        if (2 * moved > step.spacing / 5) find(), mirrors.find(context, gated), moved = 0;
        else mirrors.place(x);
        of.with_neighbours(context.pairs, of.movers, of.touched);
        parallel_for(static_cast<Index>(of.touched.size()), [&](Index c) { rho[of.touched[c]] = density(of.touched[c]); });
    }
}

void RelaxOverdensity::operator()(const InteractionContext& context, FluidPairs& pairs, SolidPairs& solid_pairs, NeighbourSearch& search,
                                  StepReport& report, Read<field::role> role, Update<field::density> rho, Update<field::position> x,
                                  Update<field::velocity> u) {
    const StepContext& step = context.step;
    const Index n = x.size();
    if (fills_periodic_domain(context, n)) return;                    // there the constraint keeps densities equal, not below rho_0
    if (context.solids.any_free() && step.gravity.isZero(0)) return;  // the bodies would have to give way
    // A fifth of a spacing more than the kernel's support, to include particles that come within it while others move. A periodic axis may
    // be too short for that.
    Real reach = step.support + step.spacing / 5;
    for (const Real length : step.domain.period())
        if (length > 0) reach = std::min(reach, length / 2);
    const auto find = [&] {
        search.find_wide(x.values, x.values, reach, step.domain, pairs);
        search.find_wide(x.values, context.boundary.position, reach, step.domain, solid_pairs);
    };
    find();
    const WallImage wall(context, gate_);
    with_kernel(step.kernel, step.support, [&](const auto& W) {
        SolveReport left;
        left.why_not = relieve(wall, W, context, role, rho.values, x.values, u.values, find);
        if (!left.why_not.empty()) report.solves.push_back({SolveKind::crowding, left});
    });
    search = {};  // frees a twentieth of a step's memory for the solve
}

}  // namespace whorl
