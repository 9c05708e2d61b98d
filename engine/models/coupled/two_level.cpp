#include "engine/models/coupled/two_level.h"

#include <algorithm>
#include <map>

#include "engine/core/parallel.h"
#include "engine/models/coupled/coarse_matrix.h"

namespace whorl {
namespace {

/// Interleaves the lowest 21 bits of three cell numbers.
std::uint64_t morton_key(const Vec3& cell) {
    const auto spread = [](std::uint64_t v) {
        v &= 0x1fffff;
        v = (v | v << 32) & 0x1f00000000ffff;
        v = (v | v << 16) & 0x1f0000ff0000ff;
        v = (v | v << 8) & 0x100f00f00f00f00f;
        v = (v | v << 4) & 0x10c30c30c30c30c3;
        v = (v | v << 2) & 0x1249249249249249;
        return v;
    };
    const auto whole = [](Real v) { return static_cast<std::uint64_t>(static_cast<std::int64_t>(v)); };
    return spread(whole(cell[0])) | spread(whole(cell[1])) << 1 | spread(whole(cell[2])) << 2;
}

}  // namespace

void TwoLevel::form_aggregates(const CoupledRows& rows, Span<const Vec3> x, Span<const std::int16_t> role, const CoupledOptions& o,
                               Real spacing, Span<std::int32_t> aggregate) {
    constexpr int sweeps = 4;
    std::fill(aggregate.begin(), aggregate.end(), 0);
    Vec3 low = Vec3::Constant(std::numeric_limits<Real>::max());
    for (std::size_t i = 0; i < x.size(); ++i)
        if (role[i] == 0) low = low.cwiseMin(x[i]);
    std::vector<std::pair<std::uint64_t, Index>> order;
    for (std::size_t i = 0; i < x.size(); ++i)
        if (role[i] == 0) order.emplace_back(morton_key((x[i] - low) * (2 / spacing)), static_cast<Index>(i));
    std::sort(order.begin(), order.end());
    const std::size_t free_particles = order.size();
    aggregates_ = static_cast<int>((free_particles + static_cast<std::size_t>(o.aggregate) - 1) / static_cast<std::size_t>(o.aggregate));
    for (std::size_t k = 0; k < free_particles; ++k)
        aggregate[static_cast<std::size_t>(order[k].second)] =
            1 + static_cast<std::int32_t>(k * static_cast<std::size_t>(aggregates_) / free_particles);

    // Lloyd: each particle joins the nearest centre among its neighbours' aggregates.
    std::vector<Vec3> centre;
    std::vector<Index> members;
    const auto find_centres = [&] {
        centre.assign(static_cast<std::size_t>(aggregates_), Vec3::Zero());
        members.assign(static_cast<std::size_t>(aggregates_), 0);
        for (std::size_t i = 0; i < x.size(); ++i)
            if (aggregate[i] > 0) {
                const auto a = static_cast<std::size_t>(aggregate[i] - 1);
                centre[a] += x[i] - low;
                ++members[a];
            }
        for (std::size_t a = 0; a < centre.size(); ++a)
            if (members[a] > 0) centre[a] = centre[a] / Real(members[a]) + low;
    };
    std::vector<std::int32_t> next(aggregate.begin(), aggregate.end());
    for (int sweep = 0; sweep < sweeps; ++sweep) {
        find_centres();
        parallel_blocks(rows.size(), CoupledRows::block_size, [&](Index begin, Index end) {
            const RowBlock& block = rows.blocks[static_cast<std::size_t>(begin / CoupledRows::block_size)];
            for (Index i = begin; i < end; ++i) {
                const auto at = static_cast<std::size_t>(i);
                if (role[at] != 0) continue;
                std::int32_t best = aggregate[at], last = best;
                Real nearest = (x[at] - centre[static_cast<std::size_t>(best - 1)]).squaredNorm();
                for (std::size_t e = block.row_begin(i - begin); e < block.row_end(i - begin); ++e) {
                    const std::int32_t a = aggregate[static_cast<std::size_t>(block.touched[static_cast<std::size_t>(block.other[e])])];
                    if (a == 0 || a == last) continue;
                    last = a;
                    const Real distance = (x[at] - centre[static_cast<std::size_t>(a - 1)]).squaredNorm();
                    if (distance < nearest) nearest = distance, best = a;
                }
                next[at] = best;
            }
        });
        std::copy(next.begin(), next.end(), aggregate.begin());
    }

    // An aggregate that lost all its members would make Ac singular.
    find_centres();
    std::vector<std::int32_t> number(centre.size(), 0);
    aggregates_ = 0;
    for (std::size_t a = 0; a < centre.size(); ++a)
        if (members[a] > 0) number[a] = ++aggregates_;
    for (std::int32_t& a : aggregate)
        if (a > 0) a = number[static_cast<std::size_t>(a - 1)];
}

void TwoLevel::place(Span<const Vec3> x, Span<const std::int16_t> role, Real spacing, Span<const std::int32_t> aggregate) {
    std::vector<Vec3d> centre(static_cast<std::size_t>(aggregates_), Vec3d::Zero());
    std::vector<Index> members(static_cast<std::size_t>(aggregates_), 0);
    of_.resize(x.size());
    arm_.resize(x.size());
    for (std::size_t i = 0; i < x.size(); ++i) {
        of_[i] = role[i] == 0 ? aggregate[i] - 1 : -1;  // it may have stuck to a solid since the aggregates were formed
        if (of_[i] < 0) continue;
        centre[static_cast<std::size_t>(of_[i])] += x[i].cast<double>();
        ++members[static_cast<std::size_t>(of_[i])];
    }
    for (std::size_t a = 0; a < centre.size(); ++a) centre[a] /= std::max<double>(1, members[a]);
    parallel_for(static_cast<Index>(x.size()), [&](Index i) {
        const auto k = static_cast<std::size_t>(i);
        arm_[k] = of_[k] < 0 ? Vec3(Vec3::Zero())
                             : Vec3(((x[k].cast<double>() - centre[static_cast<std::size_t>(of_[k])]) / spacing).cast<Real>());
    });
}

void TwoLevel::refresh(const StrainForm& form, Span<const Vec3> x, Span<const std::int16_t> role, const CoupledOptions& options,
                       Real spacing, Span<std::int32_t> aggregate) {
    form_aggregates(form.rows(), x, role, options, spacing, aggregate);
    place(x, role, spacing, aggregate);
    const Sparse Ac = coarse_matrix(form, of_, arm_, aggregates_);
    factor_ = std::make_unique<Eigen::SimplicialLLT<Sparse>>(Ac);
    if (factor_->info() != Eigen::Success) factor_.reset();
}

void TwoLevel::set(const StrainForm& form, Span<const Vec3> x, Span<const std::int16_t> role, Span<const Vec3> slip, Real spacing,
                   Span<const std::int32_t> aggregate) {
    if (factor_) place(x, role, spacing, aggregate);
    inverse_diagonal_.resize(x.size());
    form.diagonal(inverse_diagonal_);
    bool any_slip = false;
    for (std::size_t i = 0; i < x.size(); ++i) any_slip |= slip[i] != Vec3::Zero();
    slip_.clear();
    if (any_slip) slip_.assign(slip.begin(), slip.end());
    parallel_for(static_cast<Index>(x.size()), [&](Index i) {
        const auto k = static_cast<std::size_t>(i);
        Mat3& B = inverse_diagonal_[k];
        if (role[k] != 0) {
            B.setZero();
            return;
        }
        if (any_slip && slip[k] != Vec3::Zero()) {
            // (I - n n^T) B (I - n n^T) + n n^T, and the inverse without its n n^T
            const Mat3 normal = slip[k] * slip[k].transpose(), tangent = Mat3::Identity() - normal;
            const Mat3 held = tangent * B * tangent + normal;
            B = tangent * held.inverse() * tangent;
            return;
        }
        B = B.inverse().eval();
    });
}

void TwoLevel::operator()(Span<const Vec3> r, Span<Vec3> z) const {
    if (!factor_) {
        parallel_for(static_cast<Index>(r.size()), [&](Index i) {
            const auto k = static_cast<std::size_t>(i);
            z[k] = inverse_diagonal_[k] * r[k];
        });
        return;
    }
    Eigen::VectorXd load = Eigen::VectorXd::Zero(6 * aggregates_);
    for (std::size_t i = 0; i < r.size(); ++i)
        if (of_[i] >= 0) {
            const Vec3 turn = arm_[i].cross(r[i]);
            double* to = load.data() + 6 * of_[i];
            to[0] += r[i][0], to[1] += r[i][1], to[2] += r[i][2];
            to[3] += turn[0], to[4] += turn[1], to[5] += turn[2];
        }
    const Eigen::VectorXd motion = factor_->solve(load);
    parallel_for(static_cast<Index>(r.size()), [&](Index i) {
        const auto k = static_cast<std::size_t>(i);
        Vec3 v = inverse_diagonal_[k] * r[k];
        if (of_[k] >= 0) {
            const double* m = motion.data() + 6 * of_[k];
            const Vec3 shift(static_cast<Real>(m[0]), static_cast<Real>(m[1]), static_cast<Real>(m[2]));
            const Vec3 turn(static_cast<Real>(m[3]), static_cast<Real>(m[4]), static_cast<Real>(m[5]));
            Vec3 rigid = shift + turn.cross(arm_[k]);
            if (!slip_.empty()) rigid -= slip_[k] * slip_[k].dot(rigid);
            v += rigid;
        }
        z[k] = v;
    });
}

}  // namespace whorl
