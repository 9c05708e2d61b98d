#include "engine/models/viscosity/strain/coarse_level.h"

namespace whorl {

void CoarseLevel::place(Span<const Vec3> x, Span<const std::int16_t> role, Span<const std::int32_t> group, int groups, const Domain& domain,
                        Real spacing) {
    groups_ = groups;
    if (groups > 0) motions_.place(x, role, group, groups, domain, spacing);
}

void CoarseLevel::factor(const SymmetricBlocks& Ac) {
    if (!factor_.factor(Ac, motions_.centres())) groups_ = 0;
}

void CoarseLevel::solve(Span<const Vec3> r) const {
    if (groups_ == 0) return;
    load_.resize(6 * groups_);
    motions_.restrict_to_groups(r, load_);
    factor_.solve(load_);
}

void CoarseLevel::add(Span<const Vec3> r, Span<Vec3> z) const {
    if (groups_ == 0) return;
    solve(r);
    parallel_for(motions_.size(), [&](Index i) { z[i] += correction(i); });
}

void keep_definite(SymmetricBlocks& Ac) {
    for (int g = 0; g < Ac.nodes(); ++g) {
        double largest = 0;
        for (const SymmetricBlocks::Entry& e : Ac.row(g))
            if (e.column == g) largest = e.value.diagonal().maxCoeff();
        Ac.add(g, g, (largest > 0 ? 1e-7 * largest : 1) * SymmetricBlocks::Block::Identity());
    }
}

}  // namespace whorl
