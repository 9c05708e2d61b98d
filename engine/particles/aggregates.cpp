#include "engine/particles/aggregates.h"

#include "engine/particles/sort.h"

namespace whorl {

std::vector<Vec3d> aggregate_centres(Span<const Vec3> x, Span<const std::int32_t> group, int groups, const Domain& domain) {
    std::vector<Vec3d> centre(groups, Vec3d::Zero());
    std::vector<Vec3> first(groups, Vec3::Zero());
    std::vector<Index> members(groups, 0);
    for (std::size_t i = 0; i < x.size(); ++i) {
        if (group[i] <= 0) continue;
        const std::size_t g = static_cast<std::size_t>(group[i] - 1);
        if (members[g]++ == 0) first[g] = x[i];
        centre[g] += domain.minimum_image(x[i] - first[g]).cast<double>();
    }
    for (std::size_t g = 0; g < centre.size(); ++g)
        if (members[g] > 0) centre[g] = centre[g] / members[g] + first[g].cast<double>();
    return centre;
}

void Grouping::form_runs(Span<const std::int16_t> role, Real cell, int size) {
    std::fill(group.begin(), group.end(), 0);
    std::vector<Index> order;
    for (const Index i : curve_order(x, cell))
        if (role[i] == 0) order.push_back(i);
    groups = static_cast<int>((order.size() + static_cast<std::size_t>(size) - 1) / static_cast<std::size_t>(size));
    for (std::size_t k = 0; k < order.size(); ++k)
        group[order[k]] = 1 + static_cast<std::int32_t>(k * static_cast<std::size_t>(groups) / order.size());
}

void Grouping::find_centres() {
    const std::vector<Vec3d> middle = aggregate_centres(x, group, groups, domain);
    centre.resize(middle.size());
    for (std::size_t g = 0; g < centre.size(); ++g) centre[g] = middle[g].cast<Real>();
}

int Grouping::drop_empty() {
    std::vector<std::int32_t> number(groups, 0);
    for (const std::int32_t g : group)
        if (g > 0) number[g - 1] = 1;
    groups = 0;
    for (std::int32_t& n : number)
        if (n > 0) n = ++groups;
    for (std::int32_t& g : group)
        if (g > 0) g = number[g - 1];
    return groups;
}

int form_aggregates(const Pairs& pairs, Span<const Vec3> x, Span<const std::int16_t> role, const Domain& domain, Real cell, int size,
                    Span<std::int32_t> group) {
    const auto neighbours = [&](Index i, const auto& visit) {
        for (std::size_t k = pairs.first[i]; k < pairs.first[i + 1]; ++k) visit(pairs.other[k]);
    };
    return aggregate_by(neighbours, x, role, domain, cell, size, group);
}

void RigidAggregates::place(Span<const Vec3> x, Span<const std::int16_t> role, Span<const std::int32_t> group, int groups,
                            const Domain& domain, Real spacing) {
    const auto n = static_cast<Index>(x.size());
    std::vector<Index> group_of(x.size());
    parallel_for(n, [&](Index i) { group_of[i] = role[i] == 0 ? group[i] - 1 : -1; });
    groups_ = IndexGroups(std::move(group_of), groups);
    centre_ = aggregate_centres(x, group, groups, domain);
    arm_.resize(x.size());
    parallel_for(n, [&](Index i) {
        arm_[i] = of(i) < 0 ? Vec3(Vec3::Zero()) : Vec3(domain.minimum_image(x[i] - centre_[of(i)].cast<Real>()) / spacing);
    });
}

void RigidAggregates::restrict_to_groups(Span<const Vec3> r, Span<Real> load) const {
    parallel_for(groups(), [&](Index g) {
        Vec3 push = Vec3::Zero(), turn = Vec3::Zero();
        for (const Index i : members(g)) {
            push += r[i];
            turn += arm_[i].cross(r[i]);
        }
        for (std::size_t a = 0; a < 3; ++a) {
            load[6 * static_cast<std::size_t>(g) + a] = push[static_cast<int>(a)];
            load[6 * static_cast<std::size_t>(g) + 3 + a] = turn[static_cast<int>(a)];
        }
    });
}

}  // namespace whorl
