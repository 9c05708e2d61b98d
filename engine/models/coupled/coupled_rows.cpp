#include "engine/models/coupled/coupled_rows.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <numbers>
#include <numeric>

#include "engine/core/parallel.h"
#include "engine/core/resize_tightly.h"
#include "engine/models/strain/moment.h"

namespace whorl {
namespace {

/// (1 - q^2)^3 of q^2: as wide in its second moment as a Wendland kernel of 1.17 times the radius, which has 1.6 times the pairs.
Real weight_at(Real q2) {
    const Real p = std::max(Real(0), 1 - q2);
    return p * p * p;
}

/// M+, P and what follows from the eigenvalues of M.
void set_moment(const Mat3& M, const CoupledOptions& o, Neighbourhood& n) {
    const Mat3d wide = M.cast<double>();
    Eigen::SelfAdjointEigenSolver<Mat3d> axes;
    axes.computeDirect(wide, Eigen::EigenvaluesOnly);
    const Vec3d s = axes.eigenvalues();
    if (!(s[2] > 0)) return;
    n.thin = static_cast<Real>(smooth_step((o.thin_below - s[1] / s[2]) / (o.thin_below - o.thin_at)));
    const bool whole = resolves_all(s);
    if (whole) n.inverse_moment = wide.inverse().cast<Real>();
    if (whole && n.thin == 0) return;
    axes.computeDirect(wide);
    if (n.thin > 0) n.along = axes.eigenvectors().col(2).cast<Real>();
    if (whole) return;
    const Moment moment = invert_moment(axes.eigenvalues(), axes.eigenvectors());
    n.inverse_moment = moment.inverse.cast<Real>();
    n.resolved = moment.resolved.cast<Real>();
    n.unresolved = static_cast<Real>(moment.unresolved);
}

}  // namespace

/// Candidates of one row: all particles within the widest support in use, lengths in spacings.
struct CoupledRows::Scratch {
    Column<Real> x, y, z, r2, w;
    std::vector<Index> index;
    std::vector<Real> order;
    std::vector<std::size_t> bridges;
    Column<Real> row_x, row_y, row_z, row_w;  ///< pairs of the block's rows, one row after the other
    Column<Index> row_other;
    std::vector<std::size_t> row_first;
    std::vector<Index> place;    ///< of each particle in the block's touched list, -1: not in it. All -1 between two blocks
    std::vector<Index> reached;  ///< the particle whose close neighbours' close neighbours were marked last, this one among them

    unsigned long build = 0;  ///< for which `reached` was cleared

    Index place_of(Index j, RowBlock& block) {
        if (place[j] < 0) {
            place[j] = static_cast<Index>(block.touched.size());
            block.touched.push_back(j);
        }
        return place[j];
    }
    void resize(std::size_t n) {
        for (Column<Real>* c : {&x, &y, &z, &r2, &w}) c->resize(n);
        index.resize(n);
    }
    /// All neighbours of i, r = (x_j - x_i)/d. @param itself its own number among them, which is left out
    void take(const Pairs& pairs, Index i, Real inverse_spacing, Index itself) {
        resize(static_cast<std::size_t>(pairs.count(i)));
        Index end = 0;
        pairs.groups_of(i, [&](const Pairs::Group& group) {
            Real* const to[4] = {x.data() + end, y.data() + end, z.data() + end, r2.data() + end};
            for (int a = 0; a < 3; ++a)
                for (Index l = 0; l < group.count; ++l) to[a][l] = group.r[a][l] * -inverse_spacing;
            for (Index l = 0; l < group.count; ++l) to[3][l] = to[0][l] * to[0][l] + to[1][l] * to[1][l] + to[2][l] * to[2][l];
            std::copy(group.other, group.other + group.count, index.begin() + end);
            end += group.count;
        });
        const auto self = std::find(index.begin(), index.end(), itself);
        if (self == index.end()) return;
        const auto at = static_cast<std::size_t>(self - index.begin()), last = index.size() - 1;
        for (Column<Real>* c : {&x, &y, &z, &r2}) (*c)[at] = (*c)[last];
        index[at] = index[last];
        resize(last);
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
    const Real of_h0 = 1 / (h0 * h0), of_h = 1 / (h * h);
    Real density = 1;
    for (Index k = 0; k < count; ++k) {
        density += weight_at(r2[k] * of_h0);
        w[k] = r2[k] > Real(1e-12) ? weight_at(r2[k] * of_h) : 0;
    }
    return density * static_cast<Real>(315 / (64 * std::numbers::pi)) / (h0 * h0 * h0);
}

}  // namespace

void CoupledRows::build(Span<const Vec3> x, Span<const std::int16_t> role, const Domain& domain, Real spacing,
                        const CoupledOptions& options) {
    const auto n = static_cast<Index>(x.size());
    const Real support = static_cast<Real>(options.support) * spacing;
    near_search_.find(x, support, domain, near_);
    static std::atomic<unsigned long> count{0};
    builds_ = ++count;

    // h = the distance of the 16th neighbour, within [support, widest_support]: only particles without 16 neighbours in support need to
    // look further.
    const Real bridge = static_cast<Real>(options.bridge) * spacing;
    sparse_place_.assign(x.size(), -1);
    close_.resize(x.size() * most_close);
    close_count_.resize(x.size());
    parallel_for(n, [&](Index i) {
        const auto at = static_cast<std::size_t>(i);
        Index* list = close_.data() + at * most_close;
        Index listed = 0;
        near_.groups_of(i, [&](const Pairs::Group& group) {
            for (Index l = 0; l < group.count && listed < most_close; ++l) {
                list[listed] = group.other[l];
                listed += group.distance[l] < bridge;
            }
        });
        close_count_[at] = listed;
        if (near_.count(i) < options.enough_neighbours) sparse_place_[at] = 0;
    });
    sparse_.clear();
    for (std::size_t i = 0; i < x.size(); ++i)
        if (sparse_place_[i] == 0) {
            sparse_place_[i] = static_cast<Index>(sparse_.size());
            sparse_.push_back(x[i]);
        }
    if (!sparse_.empty()) far_search_.find(sparse_, x, static_cast<Real>(options.widest()) * spacing, domain, far_);

    neighbourhood.assign(x.size(), {});
    blocks.resize((n + block_size - 1) / block_size);
    parallel_blocks(n, block_size, [&](Index begin, Index end) {
        RowBlock& block = blocks[begin / block_size];
        block.begin = begin;
        block.end = end;
        build_block(block, x, role, spacing, options);
    });
    Column<Index>().swap(near_.other);  // nobody needs them any longer
    number_slots();
    pairs = slices = 0;
    widest_slice = 0;
    for (RowBlock& block : blocks) {
        block.first_slice = slices;
        slices += block.slices.size();
        for (const Index in_row : block.count) pairs += static_cast<std::size_t>(in_row);
        for (const RowSlice& slice : block.slices) widest_slice = std::max(widest_slice, slice.width);
    }
}

void CoupledRows::build_block(RowBlock& block, Span<const Vec3> x, Span<const std::int16_t> role, Real spacing, const CoupledOptions& o) {
    thread_local Scratch s;
    s.place.resize(x.size(), -1);
    if (s.reached.size() != x.size() || s.build != builds_) s.reached.assign(x.size(), -1), s.build = builds_;
    block.touched.clear();
    block.count.clear();
    s.row_first.assign(1, 0);
    for (Index i = block.begin; i < block.end; ++i) s.place_of(i, block);
    for (Index i = block.begin; i < block.end; ++i) {
        const Real h = find_candidates(i, spacing, o, s);
        neighbourhood[i].density = weigh(static_cast<Index>(s.index.size()), s.r2.data(), static_cast<Real>(o.support), h, s.w.data());
        find_bridges(i, h, o, s);
        block.count.push_back(append_row(block, i, h, role, o, s));
        s.row_first.push_back(s.row_first.back() + static_cast<std::size_t>(block.count.back()));
    }
    for (Index j : block.touched) s.place[j] = -1;
    arrange(block, s);
    find_moments(block, o);
}

/// @returns the kernel radius in spacings: the distance of the 16th neighbour where few are near
Real CoupledRows::find_candidates(Index i, Real spacing, const CoupledOptions& o, Scratch& s) const {
    const Real inverse_spacing = 1 / spacing;
    const Index sparse = sparse_place_[i];
    const Real usual = static_cast<Real>(o.support), widest = static_cast<Real>(o.widest());
    if (sparse < 0) {
        s.take(near_, i, inverse_spacing, -1);
        return usual;
    }
    s.take(far_, sparse, inverse_spacing, i);
    if (static_cast<int>(s.index.size()) < o.enough_neighbours) return widest;
    s.order.assign(s.r2.begin(), s.r2.end());
    const auto enough = s.order.begin() + (o.enough_neighbours - 1);
    std::nth_element(s.order.begin(), enough, s.order.end());
    return std::clamp(std::sqrt(*enough), usual, widest);
}

/// What pairs longer than the gate need. In the usual support: candidates that are close to one that is close to i.
void CoupledRows::find_bridges(Index i, Real h, const CoupledOptions& o, Scratch& s) const {
    const Real usual = static_cast<Real>(o.support);
    if (h == usual) {
        for (const Index bridge : close(i))
            for (const Index j : close(bridge)) s.reached[j] = i;
        return;
    }
    const Real reach = static_cast<Real>(o.bridge) * (h / usual);
    s.bridges.clear();
    for (std::size_t k = 0; k < s.index.size(); ++k)
        if (s.r2[k] < reach * reach) s.bridges.push_back(k);
}

/// Those candidates that count. @returns how many
Index CoupledRows::append_row(RowBlock& block, Index i, Real h, Span<const std::int16_t> role, const CoupledOptions& o, Scratch& s) const {
    const std::size_t begin = s.row_first.back(), most = begin + s.index.size();
    for (Column<Real>* column : {&s.row_x, &s.row_y, &s.row_z, &s.row_w})
        if (column->size() < most) column->resize(most);
    if (s.row_other.size() < most) s.row_other.resize(most);
    const Real usual = static_cast<Real>(o.support), scale = h / usual;
    const Real gate = static_cast<Real>(o.gate) * scale, reach = static_cast<Real>(o.bridge) * scale;
    std::size_t end = begin;
    for (std::size_t k = 0; k < s.index.size(); ++k) {
        if (s.w[k] == 0) continue;
        const Index j = s.index[k];
        if (s.r2[k] > gate * gate && !(role[i] != 0 && role[j] != 0)) {
            const bool counts = h == usual ? s.reached[j] == i : s.bridged(k, reach * reach);
            if (!counts) continue;
        }
        s.row_x[end] = s.x[k], s.row_y[end] = s.y[k], s.row_z[end] = s.z[k], s.row_w[end] = s.w[k];
        s.row_other[end] = s.place_of(j, block);
        ++end;
    }
    return static_cast<Index>(end - begin);
}

/// Puts rows of about the same length side by side.
void CoupledRows::arrange(RowBlock& block, const Scratch& s) {
    const Index rows = block.size();
    std::vector<Index> order(rows);
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) { return block.count[a] > block.count[b]; });
    block.slices.assign(static_cast<std::size_t>((rows + lane_count - 1) / lane_count), RowSlice());
    std::size_t end = 0;
    for (std::size_t k = 0; k < block.slices.size(); ++k) {
        RowSlice& slice = block.slices[k];
        slice.begin = end;
        slice.width = block.count[order[k * lane_count]];
        end += static_cast<std::size_t>(slice.width) * lane_count;
    }
    for (Column<Real>* column : {&block.x, &block.y, &block.z, &block.w}) resize_tightly(*column, end);
    resize_tightly(block.other, end);
    block.first.resize(rows);
    for (std::size_t k = 0; k < block.slices.size(); ++k) {
        RowSlice& slice = block.slices[k];
        slice.rows = std::min<Index>(lane_count, rows - static_cast<Index>(k) * lane_count);
        for (Index lane = 0; lane < lane_count; ++lane) {
            const Index row = order[k * lane_count + static_cast<std::size_t>(lane < slice.rows ? lane : 0)];
            const Index count = lane < slice.rows ? block.count[row] : 0;
            slice.row[lane] = row;
            std::size_t to = slice.begin + static_cast<std::size_t>(lane), from = s.row_first[row];
            if (lane < slice.rows) block.first[row] = to;
            for (Index e = 0; e < count; ++e, ++from, to += lane_count) {
                block.x[to] = s.row_x[from], block.y[to] = s.row_y[from], block.z[to] = s.row_z[from], block.w[to] = s.row_w[from];
                block.other[to] = s.row_other[from];
            }
            for (Index e = count; e < slice.width; ++e, to += lane_count) {
                block.x[to] = 1, block.y[to] = block.z[to] = block.w[to] = 0;
                block.other[to] = row;
            }
        }
    }
}

/// Sums over the finished rows: M, its inverse, what tells a surface, and the fourth moment.
void CoupledRows::find_moments(RowBlock& block, const CoupledOptions& o) {
    for (RowSlice& slice : block.slices) {
        SymmetricLanes M{};
        Lanes3 centre{};
        Lanes distances{}, weights{};
        FourthMoment& fourth = slice.fourth;
        for (Lanes& v : fourth.v) v = Lanes{};
        SliceView(block, slice).each([&](std::size_t, const Lanes3& r, const Lanes& w, const Index*) {
            const Lanes x = r.x, y = r.y, z = r.z;
            const Lanes xx = x * x, yy = y * y, zz = z * z, xy = x * y, xz = x * z, yz = y * z, r2 = xx + yy + zz;
            M.xx += w * xx, M.yy += w * yy, M.zz += w * zz, M.xy += w * xy, M.xz += w * xz, M.yz += w * yz;
            weights += w;
            centre.x += w * x, centre.y += w * y, centre.z += w * z;
            const Lanes wi = w / r2;
            distances += w * square_root(r2);
            const Lanes wxx = wi * xx, wyy = wi * yy, wzz = wi * zz;
            Lanes* f = fourth.v;
            f[0] += wxx * xx, f[1] += wxx * xy, f[2] += wxx * xz, f[3] += wxx * yy, f[4] += wxx * yz, f[5] += wxx * zz;
            f[6] += wyy * xy, f[7] += wyy * xz, f[8] += wzz * xy, f[9] += wzz * xz;
            f[10] += wyy * yy, f[11] += wyy * yz, f[12] += wyy * zz, f[13] += wzz * yz, f[14] += wzz * zz;
        });
        slice.inverse_moment = SymmetricLanes();
        for (Index lane = 0; lane < slice.rows; ++lane) {
            Neighbourhood& n = neighbourhood[block.begin + slice.row[lane]];
            const Vec3 middle(centre.x[lane], centre.y[lane], centre.z[lane]);
            n.weights = weights[lane];
            n.spread = M.xx[lane] + M.yy[lane] + M.zz[lane];
            if (distances[lane] > 0) n.surface = middle.norm() / distances[lane];
            if (n.surface > 0) n.outward = -middle.normalized();
            if (n.spread > 0) {
                Mat3 moment;
                moment << M.xx[lane], M.xy[lane], M.xz[lane], M.xy[lane], M.yy[lane], M.yz[lane], M.xz[lane], M.yz[lane], M.zz[lane];
                set_moment(moment, o, n);
            }
            slice.resolved = slice.resolved && n.unresolved == 0;
            set_lane(slice.inverse_moment, lane, n.inverse_moment);
        }
    }
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
