#include "engine/models/pressure/crowding.h"

#include <fmt/format.h>

#include <numeric>

#include "engine/core/parallel.h"
#include "engine/models/pressure/constraint.h"

namespace whorl {
namespace {

constexpr int most_sweeps = 100;

}  // namespace

void RelieveCrowding::with_neighbours(const Pairs& pairs, const std::vector<Index>& from, std::vector<Index>& all) {
    ++lists_;
    all.clear();
    const auto take = [&](Index i) {
        if (seen_[i] == lists_) return;
        seen_[i] = lists_;
        all.push_back(i);
    };
    for (const Index i : from) {
        take(i);
        for (std::size_t k = pairs.first[i]; k < pairs.first[i + 1]; ++k) take(pairs.other[k]);
    }
}

template <class Kernel>
DensityRow RelieveCrowding::row(const WallImage& wall, const Kernel& W, const Surroundings& around, Index i) {
    return density_row(
        wall, W, around, i, [](const Pairs::Group&, const Real*) {}, [](Index, const Vec3&, const WallImage::Share&) {});
}

/// Of the particles that were touched, those that are too dense. @returns the largest density
Real RelieveCrowding::find_crowded(const StepContext& step, const Fluid& fluid) {
    const Real crowded = step.rest_density * (1 + most_ / 2);
    crowded_.clear();
    Real densest = 0;
    for (const Index i : touched_) {
        if (!(fluid.rho[i] > crowded) || fluid.role[i] != 0) continue;
        crowded_.push_back(i);
        densest = std::max(densest, fluid.rho[i]);
    }
    return densest;
}

/// l_i, as what it does to the particle itself and to its neighbours.
void RelieveCrowding::set_push(const DensityRow& row, Real rho_0, Index i) {
    const Real diagonal = row.own.squaredNorm() + row.fill * row.fill * row.squares;
    const Real l = diagonal > smallest ? std::min(row.density - rho_0, rho_0 / 5) / (2 * diagonal) : 0;
    push_[i] = l * row.own;
    share_[i] = l * row.fill;
}

/// What the pushes of i and of its neighbours move i by, and what that does to its velocity.
template <class Kernel>
void RelieveCrowding::set_move(const Kernel& W, const Surroundings& around, const Fluid& fluid, Index c) {
    const Index i = movers_[c];
    const Real farthest = around.step.spacing / 5;
    Vec3 move = share_[i] > 0 ? push_[i] : Vec3(Vec3::Zero()), slower = Vec3::Zero();
    around.pairs.of(i, [&](Index j, const Vec3& r, Real distance) {
        const Real both = share_[i] + share_[j];
        if (!(both > 0)) return;
        const Real slope = around.step.mass * W.slope(distance);
        move += share_[j] * slope * r;
        const Vec3 apart = fluid.u[i] - fluid.u[j];
        slower += both * slope * (apart - apart.dot(r) / std::max(r.squaredNorm(), smallest) * r);
    });
    kicks_[c] = fluid.role[i] != 0 ? Vec3(Vec3::Zero()) : slower;
    const Real length = move.norm();
    moves_[c] = fluid.role[i] != 0 ? Vec3(Vec3::Zero()) : length > farthest ? Vec3(farthest / length * move) : move;
}

/// Moves the movers, but not into solids. @returns the farthest move [m]
Real RelieveCrowding::move(const Surroundings& around, const Fluid& fluid) {
    const Index count = static_cast<Index>(movers_.size());
    parallel_for(count, [&](Index c) {
        const Index i = movers_[c];
        share_[i] = 0;
        const Vec3 before = fluid.x[i];
        Vec3& x = fluid.x[i];
        x -= moves_[c];
        fluid.u[i] += kicks_[c];
        Real distance = 0;
        if (const int k = around.solids.nearest(x, distance); k >= 0 && distance < 0) x -= distance * around.solids.all[k].normal(x);
        moves_[c] = x - before;
    });
    return static_cast<Real>(std::sqrt(parallel_max(count, 0, [&](Index c) { return static_cast<double>(moves_[c].squaredNorm()); })));
}

template <class Kernel>
std::string RelieveCrowding::relieve(const WallImage& wall, const Kernel& W, const Surroundings& around, const Fluid& fluid,
                                     const std::function<void()>& find) {
    const Real rho_0 = around.step.rest_density;
    const Index n = static_cast<Index>(fluid.x.size());
    const auto set_density = [&](Index i) { fluid.rho[i] = row(wall, W, around, i).density; };
    parallel_for(n, set_density);
    touched_.resize(n);
    std::iota(touched_.begin(), touched_.end(), 0);
    Real moved = 0;  // at most, since the neighbours were found
    for (int sweep = 0;; ++sweep) {
        const Real densest = find_crowded(around.step, fluid);
        if (!(densest > rho_0 * (1 + Real(0.9) * most_))) return "";
        if (sweep == most_sweeps)
            return fmt::format("{} particles are still crowded, one by {:.2g} %, after {} sweeps", crowded_.size(),
                               100 * (static_cast<double>(densest / rho_0) - 1), sweep);
        parallel_for(static_cast<Index>(crowded_.size()),
                     [&](Index c) { set_push(row(wall, W, around, crowded_[c]), rho_0, crowded_[c]); });
        with_neighbours(around.pairs, crowded_, movers_);
        parallel_for(static_cast<Index>(movers_.size()), [&](Index c) { set_move(W, around, fluid, c); });
        moved += move(around, fluid);
        if (2 * moved > around.step.spacing / 5) find(), moved = 0;
        with_neighbours(around.pairs, movers_, touched_);
        parallel_for(static_cast<Index>(touched_.size()), [&](Index c) { set_density(touched_[c]); });
    }
}

void RelieveCrowding::operator()(const Surroundings& around, FluidPairs& pairs, SolidPairs& solid_pairs, StepReport& report,
                                 Read<field::role> role, Update<field::density> rho, Update<field::position> x, Update<field::velocity> u) {
    const StepContext& step = around.step;
    const Index n = x.size();
    if (fills_periodic_domain(around, n)) return;  // there densities are held equal, not below rho_0
    // A fifth of a spacing more than the kernel's reach: who comes into it while particles move is seen. A periodic axis may be too short
    // for that.
    Real reach = step.support + step.spacing / 5;
    for (const Real length : step.domain.period())
        if (length > 0) reach = std::min(reach, length / 2);
    const auto find = [&] {
        search_.find(x.values, reach, step.domain, pairs);
        solid_search_.find(x.values, around.layer.position, reach, step.domain, solid_pairs);
    };
    find();
    seen_.resize(n, 0), push_.resize(n), moves_.resize(n), kicks_.resize(n);
    share_.assign(n, 0);
    const WallImage wall(step.kernel, step.support, step.spacing, gate_);
    with_kernel(step.kernel, step.support, [&](const auto& W) {
        SolveReport left;
        left.why_not = relieve(wall, W, around, {role, rho.values, x.values, u.values}, find);
        if (!left.why_not.empty()) report.solves.push_back({std::string(name), left});
    });
}

}  // namespace whorl
