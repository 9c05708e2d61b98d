#include "engine/models/coupled/rows.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "engine/core/parallel.h"

namespace whorl {
namespace {

Real wendland(Real q) {
    const Real p = std::max(Real(0), 1 - q), p2 = p * p;
    return p2 * p2 * (1 + 4 * q);
}

double smooth_step(double t) {
    t = std::clamp(t, 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

/// M+, P and what follows from the eigenvalues of M. A direction is resolved by a smooth step of ln(s_a / s_max).
void invert_moment(const Mat3& M, const CoupledOptions& o, Neighbourhood& n) {
    const Mat3d wide = M.cast<double>();
    Eigen::SelfAdjointEigenSolver<Mat3d> eigen;
    eigen.computeDirect(wide, Eigen::EigenvaluesOnly);
    Vec3d s = eigen.eigenvalues();
    if (!(s[2] > 0)) return;
    n.thin = static_cast<Real>(smooth_step((o.thin_below - s[1] / s[2]) / (o.thin_below - o.thin_at)));
    if (s[0] >= o.resolved_above * s[2]) {
        n.inverse_moment = wide.inverse().cast<Real>();
        return;
    }
    eigen.computeDirect(wide);
    s = eigen.eigenvalues();
    const Mat3d Q = eigen.eigenvectors();
    Vec3d pi, inverse;
    double k = 0;
    for (int a = 0; a < 3; ++a) {
        const double ratio = s[a] / s[2];
        pi[a] = ratio <= 0 ? 0 : smooth_step(std::log(ratio / o.unresolved_at) / std::log(o.resolved_above / o.unresolved_at));
        inverse[a] = pi[a] > 0 ? pi[a] / s[a] : 0;
        k += 1 - pi[a] * pi[a];
    }
    n.inverse_moment = (Q * inverse.asDiagonal() * Q.transpose()).cast<Real>();
    n.resolved = (Q * pi.asDiagonal() * Q.transpose()).cast<Real>();
    n.unresolved = static_cast<Real>(k);
}

}  // namespace

/// Candidates of one row: all particles within the widest support in use, lengths in spacings.
struct CoupledRows::Scratch {
    Column<Real> x, y, z, r2;
    std::vector<Index> index;
    Column<Real> bridge_x, bridge_y, bridge_z;
    std::vector<Real> order;
    std::vector<Index> place;  ///< of each particle in the block's touched list, where stamp is 1
    std::vector<char> stamp;   ///< all 0 between two blocks

    void clear() {
        x.clear(), y.clear(), z.clear(), r2.clear(), index.clear();
    }
    void add(Index j, const Vec3& r) {
        x.push_back(r[0]), y.push_back(r[1]), z.push_back(r[2]);
        r2.push_back(r.squaredNorm());
        index.push_back(j);
    }

    /// Is there a particle closer than `reach` to both ends of pair k? The bridge lists hold those close to i, padded with far ones. The other end
    /// itself is at distance 0 and does not count.
    bool bridged(std::size_t k, Real reach2) const {
        const Real xk = x[k], yk = y[k], zk = z[k];
        int found = 0;
        for (std::size_t l = 0; l < bridge_x.size(); ++l) {
            const Real dx = bridge_x[l] - xk, dy = bridge_y[l] - yk, dz = bridge_z[l] - zk;
            const Real r = dx * dx + dy * dy + dz * dz;
            found += static_cast<int>(r < reach2) & static_cast<int>(r > 0);
        }
        return found > 0;
    }
};

void CoupledRows::build(Span<const Vec3> x, Span<const std::int16_t> role, const Domain& domain, Real spacing,
                        const CoupledOptions& options) {
    const auto n = static_cast<Index>(x.size());
    const Real support = static_cast<Real>(options.support) * spacing;
    near_search_.find(x, support, domain, near_);

    // h = 1.15 times the distance of the 16th neighbour, within [support, widest_support]: only particles without 16 neighbours in support / 1.15
    // need to look further.
    const Real dense_reach = support / Real(1.15);
    sparse_place_.assign(x.size(), -1);
    parallel_for(n, [&](Index i) {
        int close = 0;
        near_.of(i, [&](Index, const Vec3&, Real r) { close += r < dense_reach; });
        if (close < options.enough_neighbours) sparse_place_[static_cast<std::size_t>(i)] = 0;
    });
    sparse_.clear();
    for (std::size_t i = 0; i < x.size(); ++i)
        if (sparse_place_[i] == 0) {
            sparse_place_[i] = static_cast<Index>(sparse_.size());
            sparse_.push_back(x[i]);
        }
    if (!sparse_.empty()) far_search_.find(sparse_, x, static_cast<Real>(options.widest_support) * spacing, domain, far_);

    neighbourhood.assign(x.size(), {});
    blocks.resize(static_cast<std::size_t>((n + block_size - 1) / block_size));
    row_pairs_.assign(blocks.size(), 0);
    parallel_blocks(n, block_size, [&](Index begin, Index end) {
        RowBlock& block = blocks[static_cast<std::size_t>(begin / block_size)];
        block.begin = begin;
        block.end = end;
        build_block(block, x, role, spacing, options);
    });
    number_slots();
    pairs = 0;
    longest_row = 0;
    for (std::size_t b = 0; b < blocks.size(); ++b) {
        pairs += row_pairs_[b];
        for (Index row = 0; row < blocks[b].size(); ++row)
            longest_row = std::max(longest_row, blocks[b].row_end(row) - blocks[b].row_begin(row));
    }
}

void CoupledRows::build_block(RowBlock& block, Span<const Vec3> x, Span<const std::int16_t> role, Real spacing, const CoupledOptions& o) {
    thread_local Scratch s;
    s.place.resize(x.size());
    s.stamp.resize(x.size(), 0);
    block.touched.clear();
    block.first.assign(1, 0);
    block.x.clear(), block.y.clear(), block.z.clear(), block.w.clear(), block.other.clear();
    const auto place_of = [&](Index j) {
        const auto k = static_cast<std::size_t>(j);
        if (!s.stamp[k]) {
            s.stamp[k] = 1;
            s.place[k] = static_cast<Index>(block.touched.size());
            block.touched.push_back(j);
        }
        return s.place[k];
    };
    for (Index i = block.begin; i < block.end; ++i) place_of(i);

    const Real inverse_spacing = 1 / spacing;
    const Real h0 = static_cast<Real>(o.support), widest = static_cast<Real>(o.widest_support);
    const Real per_volume = static_cast<Real>(21 / (2 * std::numbers::pi * o.support * o.support * o.support));
    std::size_t counted = 0;

    for (Index i = block.begin; i < block.end; ++i) {
        const auto at = static_cast<std::size_t>(i);
        const Index sparse = sparse_place_[at];
        s.clear();
        const auto take = [&](Index j, const Vec3& r, Real) {
            if (j != i) s.add(j, r * -inverse_spacing);
        };
        if (sparse < 0) near_.of(i, take);
        else far_.of(sparse, take);
        const std::size_t candidates = s.index.size();

        Real h = h0;
        if (sparse >= 0) {
            h = widest;
            if (static_cast<int>(candidates) >= o.enough_neighbours) {
                s.order.assign(s.r2.begin(), s.r2.end());
                const auto sixteenth = s.order.begin() + (o.enough_neighbours - 1);
                std::nth_element(s.order.begin(), sixteenth, s.order.end());
                h = std::clamp(Real(1.15) * std::sqrt(*sixteenth), h0, widest);
            }
        }
        const Real scale = h / h0, gate = static_cast<Real>(o.gate) * scale, reach = static_cast<Real>(o.bridge) * scale;
        s.bridge_x.clear(), s.bridge_y.clear(), s.bridge_z.clear();
        for (std::size_t k = 0; k < candidates; ++k)
            if (s.r2[k] < reach * reach) {
                s.bridge_x.push_back(s.x[k]), s.bridge_y.push_back(s.y[k]), s.bridge_z.push_back(s.z[k]);
            }
        while (s.bridge_x.size() % lanes != 0) {
            s.bridge_x.push_back(Real(1e6)), s.bridge_y.push_back(Real(1e6)), s.bridge_z.push_back(Real(1e6));
        }

        Neighbourhood& hood = neighbourhood[at];
        Mat3 M = Mat3::Zero();
        Vec3 centre = Vec3::Zero();
        Real density = 1, spread = 0, distance_sum = 0;
        for (std::size_t k = 0; k < candidates; ++k) {
            const Real r2 = s.r2[k], r = std::sqrt(r2);
            density += wendland(r / h0);
            if (!(r < h) || r < Real(1e-6)) continue;
            const Index j = s.index[k];
            if (r > gate && !(role[at] != 0 && role[static_cast<std::size_t>(j)] != 0) && !s.bridged(k, reach * reach)) continue;
            const Real w = wendland(r / h);
            const Vec3 e(s.x[k], s.y[k], s.z[k]);
            block.x.push_back(e[0]), block.y.push_back(e[1]), block.z.push_back(e[2]), block.w.push_back(w);
            block.other.push_back(place_of(j));
            M += w * e * e.transpose();
            centre += w * e;
            spread += w * r2;
            distance_sum += w * r;
            ++counted;
        }
        const Index own = i - block.begin;
        while (block.x.size() % lanes != 0) {
            block.x.push_back(1), block.y.push_back(0), block.z.push_back(0), block.w.push_back(0);
            block.other.push_back(own);
        }
        block.first.push_back(block.x.size());

        hood.density = density * per_volume;
        hood.spread = spread;
        if (distance_sum > 0) {
            const Real length = centre.norm();
            hood.surface = length / distance_sum;
            if (length > 0) hood.outward = -centre / length;
        }
        if (spread > 0) invert_moment(M, o, hood);
    }
    row_pairs_[static_cast<std::size_t>(block.begin / block_size)] = counted;
    for (Index j : block.touched) s.stamp[static_cast<std::size_t>(j)] = 0;
}

/// Lists for every particle the places, in the blocks' order, at which blocks hold something for it.
void CoupledRows::number_slots() {
    first_slot_.assign(neighbourhood.size() + 1, 0);
    std::size_t place = 0;
    for (RowBlock& block : blocks) {
        block.place = place;
        place += block.touched.size();
        for (Index j : block.touched) ++first_slot_[static_cast<std::size_t>(j) + 1];
    }
    for (std::size_t i = 1; i < first_slot_.size(); ++i) first_slot_[i] += first_slot_[i - 1];
    slot_.resize(place);
    std::vector<std::size_t> next(first_slot_.begin(), first_slot_.end() - 1);
    for (const RowBlock& block : blocks)
        for (std::size_t l = 0; l < block.touched.size(); ++l) slot_[next[static_cast<std::size_t>(block.touched[l])]++] = block.place + l;
}

}  // namespace whorl
