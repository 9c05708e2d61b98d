#include "engine/models/viscosity/strain/coarse_level.h"

namespace whorl {

void CoarseLevel::place(Span<const Vec3> x, Span<const std::int16_t> role, Span<const std::int32_t> group, int groups, const Domain& domain,
                        Real spacing, Span<const Vec3d> bodies) {
    bodies_ = groups > 0 ? static_cast<int>(bodies.size()) : 0;
    groups_ = groups + bodies_;
    spacing_ = spacing;
    if (groups_ > 0) motions_.place(x, role, group, groups_, domain, spacing);
    for (int b = 0; b < bodies_; ++b) motions_.set_centre(groups + b, bodies[static_cast<std::size_t>(b)]);
}

void CoarseLevel::factor(const SymmetricBlocks& Ac) {
    if (!factor_.factor(Ac, motions_.centres())) clear();
}

void CoarseLevel::solve(Span<const Vec3> r) const {
    if (groups_ == 0) return;
    load_.resize(6 * groups_);
    motions_.restrict_to_groups(r, load_);
    for (std::size_t k = 0; k < 2 * static_cast<std::size_t>(bodies_); ++k) {
        const Vec3 f = (k % 2 == 0 ? 1 : 1 / spacing_) * r[static_cast<std::size_t>(motions_.size()) + k];
        std::copy_n(f.data(), 3, load_.begin() + static_cast<std::ptrdiff_t>(6 * static_cast<std::size_t>(groups_of_particles()) + 3 * k));
    }
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
