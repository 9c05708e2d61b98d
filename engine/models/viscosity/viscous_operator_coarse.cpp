// R^T A R of the viscous operator, computed directly from each particle's strain and penalty under the rigid motions of the groups around
// it.
#include <limits>

#include "engine/core/parallel.h"
#include "engine/models/viscosity/viscous_operator.h"

namespace whorl {
namespace {

using Block = SymmetricBlocks::Block;
using Mat4 = Eigen::Matrix<double, 4, 4>;
/// Rows: 1 and the three components of the arm; columns: components of w r.
using Moments = Eigen::Matrix<Real, 4, 3>;
using Vec4 = Eigen::Matrix<Real, 4, 1>;
/// Columns: xx, yy, zz, xy, xz, yz of a strain, the last three times sqrt 2. Rows: the six motions and two unused, for a vector register.
using Strains = Eigen::Matrix<Real, 8, 6>;

/// Strain rates sym(P G) at one particle of the unit motions of one group: G = A M^+ with A = sum w u r^T over that group.
/// @param P null: 1
Strains strains(const Moments& T, const Mat3* P) {
    const Real h = Real(0.70710678118654752);
    Strains F = Strains::Zero();
    for (int mode = 0; mode < 6; ++mode) {
        Mat3 D = Mat3::Zero();
        if (mode < 3) {
            D.row(mode) = T.row(0);
        } else {
            const int p = (mode - 2) % 3, q = (mode - 1) % 3;  // e_n x arm: component n + 1 is -arm_(n+2), component n + 2 is arm_(n+1)
            D.row(p) = -T.row(1 + q);
            D.row(q) = T.row(1 + p);
        }
        if (P) D = *P * D;
        F.row(mode) << D(0, 0), D(1, 1), D(2, 2), h * (D(0, 1) + D(1, 0)), h * (D(0, 2) + D(2, 0)), h * (D(1, 2) + D(2, 1));
    }
    return F;
}

/// Inner products u.v of the motions of two groups, from the sums C = sum (1, arm) (1, arm')^T.
Block inner_products(const Mat4& C) {
    Block m = Block::Zero();
    m.topLeftCorner<3, 3>().diagonal().setConstant(C(0, 0));
    const auto cross = [](double a, double b, double c) {  // m, n -> sum_k eps_mnk (a, b, c)_k
        Mat3d e;
        e << 0, c, -b, -c, 0, a, b, -a, 0;
        return e;
    };
    m.topRightCorner<3, 3>() = cross(C(0, 1), C(0, 2), C(0, 3));
    m.bottomLeftCorner<3, 3>() = cross(C(1, 0), C(2, 0), C(3, 0)).transpose();
    const Mat3d arms = C.bottomRightCorner<3, 3>();
    m.bottomRightCorner<3, 3>() = arms.trace() * Mat3d::Identity() - arms.transpose();
    return m;
}

Vec4 lever(const Vec3& arm) { return {1, arm[0], arm[1], arm[2]}; }

}  // namespace

/// Contribution of some rows to Ac.
struct ViscousOperator::CoarseRows {
    /// Contribution to the block of two groups.
    struct PairSum {
        Eigen::Matrix<Real, 8, 6> strain = Eigen::Matrix<Real, 8, 6>::Zero();
        Mat4 products = Mat4::Zero();
    };
    /// Part of one group in a particle's sums.
    struct Share {
        int number;   ///< number of the group in sums
        Moments S;    ///< sum w (1, arm) r^T, with the sign of u_i - u_j
        Vec4 spring;  ///< sum 2 w (c_i + c_j) (1, arm)
        Moments T;    ///< S M^+
        Strains F;
    };

    const ViscousOperator& A;
    const RigidAggregates& groups;
    GroupSums<PairSum> sums{};
    std::vector<Share> shares{};  ///< shares of one particle
    Real springs = 0;             ///< springs of the same particle: the part of u_i.v_i

    void add(Index i) {
        find_shares(i);
        add_strains(i);
        if (groups.of(i) >= 0) add_own_motion(i);
    }

private:
    Share& share_of(int group);
    void find_shares(Index i);
    void add_strains(Index i);
    void add_own_motion(Index i);
};

ViscousOperator::CoarseRows::Share& ViscousOperator::CoarseRows::share_of(int group) {
    const int number = sums.number(group);
    for (Share& s : shares)
        if (s.number == number) return s;
    return shares.emplace_back(Share{number, Moments::Zero(), Vec4::Zero(), {}, {}});
}

void ViscousOperator::CoarseRows::find_shares(Index i) {
    shares.clear();
    if (const int own = groups.of(i); own >= 0) share_of(own).S += lever(groups.arm(i)) * A.wr_[i].wr.transpose();
    springs = 1 + (A.wall_.empty() ? 0 : A.wall_[i].near.spring);
    A.each_pair(i, [&](Index j, const Pair& pair) {
        springs += pair.spring;
        if (groups.of(j) < 0) return;
        Share& s = share_of(groups.of(j));
        const Vec4 arm = lever(groups.arm(j));
        s.S -= arm * pair.wr.transpose();
        s.spring += pair.spring * arm;
    });
}

void ViscousOperator::CoarseRows::add_strains(Index i) {
    const Real c = 2 * A.c_[i], root = std::sqrt(2 * A.K_[i]);
    const Mat3 P = A.P_[i].matrix();
    for (Share& s : shares) {
        s.T = s.S * A.M_[i].matrix();
        s.F = root * strains(s.T, A.whole_[i] ? nullptr : &P);
    }
    for (const Share& a : shares)
        for (const Share& b : shares) {
            if (b.number > a.number) continue;
            PairSum& sum = sums.sum(a.number, b.number);
            sum.strain.noalias() += a.F * b.F.topRows<6>().transpose();
            sum.products -= (c * (a.T * b.S.transpose())).cast<double>();
        }
}

/// Adds mass, friction and the sum over the pairs of 2 w (c_i + c_j) u_ij.v_ij. Of this sum it adds the part in u_i.v_i, and the part in
/// -u_i.v_j if i's group comes first; otherwise row j adds the latter.
void ViscousOperator::CoarseRows::add_own_motion(Index i) {
    const Vec3& a = groups.arm(i);
    const Vec4 arm = lever(a);
    const int own = groups.of(i), self = sums.number(own);
    if (A.friction_.acts()) {
        Eigen::Matrix<Real, 3, 6> motion;  // v + omega x arm
        motion << Mat3::Identity(), Vec3::UnitX().cross(a), Vec3::UnitY().cross(a), Vec3::UnitZ().cross(a);
        sums.sum(self, self).strain.topRows<6>() += motion.transpose() * A.friction_coefficient(i) * motion;
    }
    // The factor keeps the rounding of the sums from letting a rigid motion gain energy.
    sums.sum(self, self).products += ((1 + 16 * std::numeric_limits<Real>::epsilon()) * springs * arm * arm.transpose()).cast<double>();
    for (const Share& b : shares) {
        if (sums.group(b.number) > own) continue;
        if (b.number <= self) sums.sum(self, b.number).products -= (arm * b.spring.transpose()).cast<double>();
        else sums.sum(b.number, self).products -= (b.spring * arm.transpose()).cast<double>();
    }
}

SymmetricBlocks ViscousOperator::coarse_matrix(const RigidAggregates& g) const {
    // A task handles the members of a group, or those particles in a block of 1024 that belong to no group.
    constexpr Index outside = 1024;
    const Index n = size(), tasks = g.groups() + (n + outside - 1) / outside;
    const auto rows_of = [&](Index task, GroupSums<CoarseRows::PairSum>& sums) {
        CoarseRows rows{*this, g};
        if (task < g.groups()) {
            for (const Index i : g.members(task)) rows.add(i);
        } else {
            const Index begin = (task - g.groups()) * outside;
            for (Index i = begin; i < std::min(n, begin + outside); ++i)
                if (g.of(i) < 0) rows.add(i);
        }
        sums = std::move(rows.sums);
    };
    return coarse_blocks<CoarseRows::PairSum>(g.groups(), tasks, rows_of, [](const CoarseRows::PairSum& sum) {
        return SymmetricBlocks::Block(sum.strain.topRows<6>().cast<double>() + inner_products(sum.products));
    });
}

}  // namespace whorl
