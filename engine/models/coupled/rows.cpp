#include "engine/models/coupled/rows.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <atomic>
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
    const bool resolved = s[0] >= o.resolved_above * s[2];
    if (resolved) n.inverse_moment = wide.inverse().cast<Real>();
    if (resolved && n.thin == 0) return;
    eigen.computeDirect(wide);
    s = eigen.eigenvalues();
    if (n.thin > 0) n.along = eigen.eigenvectors().col(2).cast<Real>();
    if (resolved) return;
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
    Column<Real> x, y, z, r2, w;
    std::vector<Index> index;
    std::vector<Real> order;
    std::vector<std::size_t> bridges;
    std::vector<Index> place;    ///< of each particle in the block's touched list, -1: not in it. All -1 between two blocks
    std::vector<Index> reached;  ///< the particle whose close neighbours' close neighbours were marked last, this one among them

    unsigned long build = 0;  ///< for which `reached` was cleared

    void clear() { x.clear(), y.clear(), z.clear(), r2.clear(), index.clear(); }
    void add(Index j, const Vec3& r) {
        x.push_back(r[0]), y.push_back(r[1]), z.push_back(r[2]);
        r2.push_back(r.squaredNorm());
        index.push_back(j);
    }
    /// Is there a candidate closer than `reach` to both the particle and candidate k? `bridges` lists those close to the particle.
    bool bridged(std::size_t k, Real reach2) const {
        for (const std::size_t l : bridges) {
            const Real dx = x[l] - x[k], dy = y[l] - y[k], dz = z[l] - z[k];
            if (l != k && dx * dx + dy * dy + dz * dz < reach2) return true;
        }
        return false;
    }
};

namespace {

/// The weights of all candidates, 0 beyond h; returns n/n0.
Real weigh(Index count, const Real* __restrict r2, Real h0, Real h, Real* __restrict w) {
    const Real inverse_h0 = 1 / h0, inverse_h = 1 / h;
    Real density = 1;
    for (Index k = 0; k < count; ++k) {
        const Real r = std::sqrt(r2[k]);
        density += wendland(r * inverse_h0);
        w[k] = r2[k] > Real(1e-12) ? wendland(r * inverse_h) : 0;
    }
    return density * static_cast<Real>(21 / (2 * std::numbers::pi)) / (h0 * h0 * h0);
}

/// Sums over a finished row: M, and what tells a surface.
Mat3 moments(Index count, const Real* __restrict x, const Real* __restrict y, const Real* __restrict z, const Real* __restrict w,
             Neighbourhood& n) {
    Real xx = 0, yy = 0, zz = 0, xy = 0, xz = 0, yz = 0, sx = 0, sy = 0, sz = 0, distances = 0;
    for (Index e = 0; e < count; ++e) {
        const Real wx = w[e] * x[e], wy = w[e] * y[e], wz = w[e] * z[e];
        xx += wx * x[e], yy += wy * y[e], zz += wz * z[e], xy += wx * y[e], xz += wx * z[e], yz += wy * z[e];
        sx += wx, sy += wy, sz += wz;
        distances += w[e] * std::sqrt(x[e] * x[e] + y[e] * y[e] + z[e] * z[e]);
    }
    const Vec3 centre(sx, sy, sz);
    n.spread = xx + yy + zz;
    if (distances > 0) n.surface = centre.norm() / distances;
    if (n.surface > 0) n.outward = -centre.normalized();
    Mat3 M;
    M << xx, xy, xz, xy, yy, yz, xz, yz, zz;
    return M;
}

}  // namespace

void CoupledRows::build(Span<const Vec3> x, Span<const std::int16_t> role, const Domain& domain, Real spacing,
                        const CoupledOptions& options) {
    const auto n = static_cast<Index>(x.size());
    const Real support = static_cast<Real>(options.support) * spacing;
    near_search_.find(x, support, domain, near_);
    static std::atomic<unsigned long> count{0};
    builds_ = ++count;

    // h = 1.15 times the distance of the 16th neighbour, within [support, widest_support]: only particles without 16 neighbours in support
    // / 1.15 need to look further.
    const Real dense_reach = support / Real(1.15);
    const Real bridge = static_cast<Real>(options.bridge) * spacing;
    sparse_place_.assign(x.size(), -1);
    close_.resize(x.size() * most_close);
    close_count_.resize(x.size());
    parallel_for(n, [&](Index i) {
        const auto at = static_cast<std::size_t>(i);
        Index* list = close_.data() + at * most_close;
        Index listed = 0;
        int dense = 0;
        near_.of(i, [&](Index j, const Vec3&, Real r) {
            dense += r < dense_reach;
            if (r < bridge && listed < most_close) list[listed++] = j;
        });
        close_count_[at] = listed;
        if (dense < options.enough_neighbours) sparse_place_[at] = 0;
    });
    sparse_.clear();
    for (std::size_t i = 0; i < x.size(); ++i)
        if (sparse_place_[i] == 0) {
            sparse_place_[i] = static_cast<Index>(sparse_.size());
            sparse_.push_back(x[i]);
        }
    if (!sparse_.empty()) far_search_.find(sparse_, x, static_cast<Real>(options.widest_support) * spacing, domain, far_);

    neighbourhood.assign(x.size(), {});
    blocks.resize((n + block_size - 1) / block_size);
    row_pairs_.assign(blocks.size(), 0);
    parallel_blocks(n, block_size, [&](Index begin, Index end) {
        RowBlock& block = blocks[begin / block_size];
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
    s.place.resize(x.size(), -1);
    if (s.reached.size() != x.size() || s.build != builds_) s.reached.assign(x.size(), -1), s.build = builds_;
    block.touched.clear();
    block.first.assign(1, 0);
    const auto place_of = [&](Index j) {
        Index& place = s.place[j];
        if (place < 0) {
            place = static_cast<Index>(block.touched.size());
            block.touched.push_back(j);
        }
        return place;
    };
    for (Index i = block.begin; i < block.end; ++i) place_of(i);

    const Real inverse_spacing = 1 / spacing;
    const Real h0 = static_cast<Real>(o.support), widest = static_cast<Real>(o.widest_support);
    std::size_t counted = 0, end = 0;

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
                const auto enough = s.order.begin() + (o.enough_neighbours - 1);
                std::nth_element(s.order.begin(), enough, s.order.end());
                h = std::clamp(Real(1.15) * std::sqrt(*enough), h0, widest);
            }
        }
        Neighbourhood& hood = neighbourhood[at];
        s.w.resize(candidates);
        hood.density = weigh(static_cast<Index>(candidates), s.r2.data(), h0, h, s.w.data());

        // Pairs longer than the gate need a bridge. In the normal support: candidates that are close to one that is close to i.
        const Real scale = h / h0, gate = static_cast<Real>(o.gate) * scale, reach = static_cast<Real>(o.bridge) * scale;
        if (h == h0) {
            for (Index k = 0; k < close_count_[at]; ++k) {
                const auto bridge = static_cast<std::size_t>(close_[at * most_close + k]);
                for (Index l = 0; l < close_count_[bridge]; ++l) s.reached[close_[bridge * most_close + l]] = i;
            }
        } else {
            s.bridges.clear();
            for (std::size_t k = 0; k < candidates; ++k)
                if (s.r2[k] < reach * reach) s.bridges.push_back(k);
        }

        const std::size_t begin = end;
        for (Column<Real>* column : {&block.x, &block.y, &block.z, &block.w})
            if (column->size() < begin + candidates + lanes) column->resize(2 * (begin + candidates + lanes));
        if (block.other.size() < block.x.size()) block.other.resize(block.x.size());
        for (std::size_t k = 0; k < candidates; ++k) {
            if (s.w[k] == 0) continue;
            const Index j = s.index[k];
            if (s.r2[k] > gate * gate && !(role[at] != 0 && role[j] != 0)) {
                const bool counts = h == h0 ? s.reached[j] == i : s.bridged(k, reach * reach);
                if (!counts) continue;
            }
            block.x[end] = s.x[k], block.y[end] = s.y[k], block.z[end] = s.z[k], block.w[end] = s.w[k];
            block.other[end] = place_of(j);
            ++end;
        }
        counted += end - begin;
        for (; (end - begin) % lanes != 0; ++end) {
            block.x[end] = 1, block.y[end] = 0, block.z[end] = 0, block.w[end] = 0;
            block.other[end] = i - block.begin;
        }
        block.first.push_back(end);
        const Mat3 M = moments(static_cast<Index>(end - begin), block.x.data() + begin, block.y.data() + begin, block.z.data() + begin,
                               block.w.data() + begin, hood);
        if (hood.spread > 0) invert_moment(M, o, hood);
    }
    row_pairs_[block.begin / block_size] = counted;
    for (Index j : block.touched) s.place[j] = -1;
}

/// Lists for every particle the places, in the blocks' order, at which blocks hold something for it.
void CoupledRows::number_slots() {
    first_slot_.assign(neighbourhood.size() + 1, 0);
    std::size_t place = 0;
    for (RowBlock& block : blocks) {
        block.place = place;
        place += block.touched.size();
        for (Index j : block.touched) ++first_slot_[j + 1];
    }
    for (std::size_t i = 1; i < first_slot_.size(); ++i) first_slot_[i] += first_slot_[i - 1];
    slot_.resize(place);
    std::vector<std::size_t> next(first_slot_.begin(), first_slot_.end() - 1);
    for (const RowBlock& block : blocks)
        for (std::size_t l = 0; l < block.touched.size(); ++l) slot_[next[block.touched[l]]++] = block.place + l;
}

}  // namespace whorl
