#include "engine/models/coupled/coarse_matrix.h"

#include <algorithm>

#include "engine/core/parallel.h"
#include "engine/models/strain/coarse_level.h"

namespace whorl {
namespace {

using Mat6 = Eigen::Matrix<Real, 6, 6>;
using Mat36 = Eigen::Matrix<Real, 3, 6>;
using Mat15x6 = Eigen::Matrix<Real, 15, 6>;
using Vec6 = Eigen::Matrix<Real, 6, 1>;

/// E with v + omega x arm = E (v, omega).
Mat36 motion(const Vec3& a) {
    Mat36 E;
    E << 1, 0, 0, 0, a[2], -a[1],  //
        0, 1, 0, -a[2], 0, a[0],   //
        0, 0, 1, a[1], -a[0], 0;
    return E;
}

/// The numbers that all sums over a row's pairs are made of. With q = (xx, yy, zz, xy, xz, yz) of r and u = v + omega x arm every sum of
/// the form below is one of (1, arm) times one of these, so that a pair costs a few vector operations.
struct alignas(8 * sizeof(Real)) Monomials {
    static constexpr int count = 40, levered = 24, springs = 16;
    Real v[count];  ///< w r; w/r^2 times the ten cubes; three spare; W (xx, yy, zz, xy, xz, yz) from `springs` on; two spare; from
                    ///< `levered` on w/r^2 times the fifteen fourth powers
};

/// The cube x_a q_k, and the fourth power q_k q_l, by their place among the distinct ones.
constexpr int cube[3][6] = {{0, 3, 5, 1, 2, 4}, {1, 6, 8, 3, 4, 7}, {2, 7, 9, 4, 5, 8}};
constexpr int fourth[6][6] = {{0, 3, 5, 1, 2, 4}, {3, 10, 12, 6, 7, 11}, {5, 12, 14, 8, 9, 13},
                              {1, 6, 8, 3, 4, 7}, {2, 7, 9, 4, 5, 8},    {4, 11, 13, 7, 8, 12}};

void find_monomials(const RowBlock& block, Index row, const StrainCoefficients& c, std::vector<Monomials>& pairs) {
    pairs.resize(static_cast<std::size_t>(block.count[row]));
    Monomials* to = pairs.data();
    block.each_pair(row, [&](std::size_t e) {
        const Real x = block.x[e], y = block.y[e], z = block.z[e], w = block.w[e];
        const Real xx = x * x, yy = y * y, zz = z * z, xy = x * y, xz = x * z, yz = y * z;
        const Real wi = w / (xx + yy + zz), cw = c.smooth * w, pw = c.pair * wi;
        const Real wxx = wi * xx, wyy = wi * yy, wzz = wi * zz, wyz = wi * yz;
        Real* m = (to++)->v;
        m[0] = w * x, m[1] = w * y, m[2] = w * z;
        m[3] = wxx * x, m[4] = wxx * y, m[5] = wxx * z, m[6] = wyy * x, m[7] = wyz * x, m[8] = wzz * x;
        m[9] = wyy * y, m[10] = wyy * z, m[11] = wzz * y, m[12] = wzz * z;
        m[13] = m[14] = m[15] = 0;
        m[16] = cw + pw * xx, m[17] = cw + pw * yy, m[18] = cw + pw * zz, m[19] = pw * xy, m[20] = pw * xz, m[21] = pw * yz;
        m[22] = m[23] = 0;
        m[24] = wxx * xx, m[25] = wxx * xy, m[26] = wxx * xz, m[27] = wxx * yy, m[28] = wxx * yz, m[29] = wxx * zz;
        m[30] = wyy * xy, m[31] = wyy * xz, m[32] = wzz * xy, m[33] = wzz * xz;
        m[34] = wyy * yy, m[35] = wyy * yz, m[36] = wyy * zz, m[37] = wzz * yz, m[38] = wzz * zz;
        m[39] = 0;
    });
}

/// sum += m for `count` numbers.
template <int count>
void add_to(Real* __restrict sum, const Real* __restrict m) {
    for (int k = 0; k < count; ++k) sum[k] += m[k];
}

Mat3 springs_of(const Real* m) {
    Mat3 W;
    W << m[0], m[3], m[4], m[3], m[1], m[5], m[4], m[5], m[2];
    return W;
}

/// Sums of the monomials times 1 and the three components of the arm.
struct alignas(8 * sizeof(Real)) LeveredSums {
    Real v[4][Monomials::levered] = {};
    void add(const Real* __restrict m, const Vec3& arm) {
        const Real ax = arm[0], ay = arm[1], az = arm[2];
        for (int k = 0; k < Monomials::levered; ++k) {
            const Real one = m[k];
            v[0][k] += one, v[1][k] += ax * one, v[2][k] += ay * one, v[3][k] += az * one;
        }
    }
    Vec3 s() const { return Vec3(v[0][0], v[0][1], v[0][2]); }
    Mat36 b() const {
        Mat36 b;
        for (int a = 0; a < 3; ++a)
            for (int k = 0; k < 6; ++k) b(a, k) = v[0][3 + cube[a][k]];
        return b;
    }
    Mat3 springs() const { return springs_of(v[0] + Monomials::springs); }
};

/// What the members of one aggregate add to the sums of one row, by unit rigid motion.
struct Share {
    int aggregate = -1;  ///< its number in GroupSums; -1: those in none
    LeveredSums sums;
    Vec3 s;        ///< sum w r
    Mat3 arm_s;    ///< sum w arm r^T
    Mat36 b;       ///< sum w/r^2 r q^T
    Mat36 arm_b;   ///< sum w/r^2 (arm x r) q^T
    Mat36 spring;  ///< sum W E, W = 2 c w + 2 c' w/r^2 r r^T
    explicit Share(int a) : aggregate(a) {}
    void unpack() {
        s = sums.s(), b = sums.b();
        for (int p = 0; p < 3; ++p) {
            const int q = (p + 1) % 3, r = (p + 2) % 3;
            for (int k = 0; k < 3; ++k) arm_s(p, k) = sums.v[1 + p][k];
            for (int k = 0; k < 6; ++k) arm_b(p, k) = sums.v[1 + q][3 + cube[r][k]] - sums.v[1 + r][3 + cube[q][k]];
        }
        const Mat3 x = springs_of(sums.v[1] + Monomials::springs), y = springs_of(sums.v[2] + Monomials::springs),
                   z = springs_of(sums.v[3] + Monomials::springs);
        spring.leftCols<3>() = sums.springs();
        spring.col(3) = y.col(2) - z.col(1), spring.col(4) = z.col(0) - x.col(2), spring.col(5) = x.col(1) - y.col(0);
    }
};

/// Rows 0 to 8: A = sum w u r^T (row by row) for each of the six motions; rows 9 to 14: sum w/r^2 (u.r) q.
Mat15x6 features(const Share& share) {
    Mat15x6 F;
    for (int mode = 0; mode < 3; ++mode) {
        // v = e_mode: A = e_mode s^T.   omega = e_mode: u = e_mode x arm, A = [e_mode]x sum w arm r^T.
        Mat3 A = Mat3::Zero(), turned = Mat3::Zero();
        A.row(mode) = share.s.transpose();
        const int p = (mode + 1) % 3, q = (mode + 2) % 3;
        turned.row(p) = -share.arm_s.row(q);
        turned.row(q) = share.arm_s.row(p);
        for (int row = 0; row < 3; ++row)
            for (int col = 0; col < 3; ++col) {
                F(3 * row + col, mode) = A(row, col);
                F(3 * row + col, 3 + mode) = turned(row, col);
            }
        F.block<6, 1>(9, mode) = share.b.row(mode).transpose();
        F.block<6, 1>(9, 3 + mode) = share.arm_b.row(mode).transpose();
    }
    return F;
}

Mat3 from_six(const Vec6& h) {
    Mat3 H;
    H << h[0], h[3], h[4], h[3], h[1], h[5], h[4], h[5], h[2];
    return H;
}

/// The derivative of the row's energy by its features, without the springs' own sum w |u_ij|^2 parts.
Mat15x6 derivative(const Mat15x6& F, const Neighbourhood& n, const StrainCoefficients& c, const Eigen::Matrix<Real, 6, 6>& C4) {
    Mat15x6 out;
    for (int mode = 0; mode < 6; ++mode) {
        Mat3 A;
        for (int k = 0; k < 9; ++k) A(k / 3, k % 3) = F(k, mode);
        const Mat3 G = A * n.inverse_moment;
        const Mat3 D = n.resolved * G;
        const Mat3 sym = Real(0.5) * (D + D.transpose());
        Mat3 S = c.shear * sym;
        S.diagonal().array() += c.bulk * sym.trace();
        Vec6 g;
        g << G(0, 0), G(1, 1), G(2, 2), G(0, 1) + G(1, 0), G(0, 2) + G(2, 0), G(1, 2) + G(2, 1);
        const Vec6 h = C4 * g - F.block<6, 1>(9, mode);
        const Mat3 Q = (n.resolved * S + c.pair * from_six(h)) * n.inverse_moment - c.smooth * G;
        for (int k = 0; k < 9; ++k) out(k, mode) = Q(k / 3, k % 3);
        out.block<6, 1>(9, mode) = -c.pair * g;
    }
    return out;
}

struct BlockSum {
    SymmetricBlocks::Block value = SymmetricBlocks::Block::Zero();
};

/// What one block of rows adds to Ac.
class CoarseRows {
public:
    CoarseRows(const StrainForm& form, const RigidAggregates& aggregates, const RowBlock& block, GroupSums<BlockSum>& sums);
    void add_row(Index row);
    /// The springs' part of u_j.u_j, once all rows are added; with it mass and friction.
    void add_springs();

private:
    struct alignas(8 * sizeof(Real)) Springs {
        Real v[8] = {};
    };
    Share& share_of(int aggregate);
    Mat6 find_shares(Index row);
    void add_coupling(Index row);
    void add_strains(const Neighbourhood& n, const StrainCoefficients& c, const Mat6& C4);
    void add(int a, int b, const Mat6& m);

    const StrainForm& form_;
    const RigidAggregates& aggregates_;
    const RowBlock& block_;
    GroupSums<BlockSum>& sums_;
    std::vector<Springs> springs_;  ///< sum of W over all pairs of a particle that the block touches
    std::vector<int> number_;       ///< of its aggregate in sums_, -1: in none
    std::vector<Monomials> pairs_;  ///< of one row
    std::vector<Share> shares_;     ///< of one row, that of the row's own particle first
    std::vector<Mat15x6> F_, dF_;
};

CoarseRows::CoarseRows(const StrainForm& form, const RigidAggregates& aggregates, const RowBlock& block, GroupSums<BlockSum>& sums)
    : form_(form), aggregates_(aggregates), block_(block), sums_(sums), springs_(block.touched.size()), number_(block.touched.size()) {
    for (std::size_t place = 0; place < number_.size(); ++place) {
        const std::int32_t a = aggregates.of(block.touched[place]);
        number_[place] = a < 0 ? -1 : sums.number(a);
    }
}

Share& CoarseRows::share_of(int aggregate) {
    for (Share& s : shares_)
        if (s.aggregate == aggregate) return s;
    return shares_.emplace_back(aggregate);
}

void CoarseRows::add(int a, int b, const Mat6& m) {
    SymmetricBlocks::Block& to = sums_.sum(std::max(a, b), std::min(a, b)).value;
    if (a >= b) to += m.cast<double>();
    else to += m.transpose().cast<double>();
}

void CoarseRows::add_row(Index row) {
    if (block_.count[row] == 0) return;
    const Index i = block_.begin + row;
    const Mat6 C4 = find_shares(row);
    if (number_[row] >= 0) add_coupling(row);
    add_strains(form_.rows().neighbourhood[i], form_.coefficients(i), C4);
}

/// @returns sum w/r^2 q q^T
Mat6 CoarseRows::find_shares(Index row) {
    shares_.clear();
    share_of(number_[row]);
    find_monomials(block_, row, form_.coefficients(block_.begin + row), pairs_);
    alignas(8 * sizeof(Real)) Real quartic[Monomials::count - Monomials::levered] = {};
    const Monomials* pair = pairs_.data();
    block_.each_pair(row, [&](std::size_t e) {
        const Index place = block_.other[e];
        const Real* m = (pair++)->v;
        share_of(number_[place]).sums.add(m, aggregates_.arm(block_.touched[place]));
        add_to<8>(springs_[place].v, m + Monomials::springs);
        add_to<Monomials::count - Monomials::levered>(quartic, m + Monomials::levered);
    });
    Mat6 C4;
    for (int k = 0; k < 6; ++k)
        for (int l = 0; l < 6; ++l) C4(k, l) = quartic[fourth[k][l]];
    for (Share& share : shares_) {
        share.unpack();
        add_to<8>(springs_[row].v, share.sums.v[0] + Monomials::springs);
    }
    return C4;
}

/// The row's own particle is in each of its pairs: the springs' part of u_i.u_j, and its share of the sums.
void CoarseRows::add_coupling(Index row) {
    const Vec3& a = aggregates_.arm(block_.begin + row);
    const Mat36 E = motion(a);
    const int own = number_[row];
    Vec3 s_sum = Vec3::Zero();
    Mat36 b_sum = Mat36::Zero();
    for (const Share& share : shares_) {
        s_sum += share.s, b_sum += share.b;
        if (share.aggregate < 0) continue;
        const Mat6 coupling = -E.transpose().lazyProduct(share.spring);
        add(own, share.aggregate, coupling);
        if (share.aggregate == own) add(own, own, Mat6(coupling.transpose()));
    }
    Share& share = shares_.front();
    share.s -= s_sum;
    share.arm_s -= a * s_sum.transpose();
    share.b -= b_sum;
    for (int k = 0; k < 6; ++k) share.arm_b.col(k) -= a.cross(Vec3(b_sum.col(k)));
}

void CoarseRows::add_strains(const Neighbourhood& n, const StrainCoefficients& c, const Mat6& C4) {
    F_.resize(shares_.size()), dF_.resize(shares_.size());
    for (std::size_t k = 0; k < shares_.size(); ++k) {
        if (shares_[k].aggregate < 0) continue;
        F_[k] = features(shares_[k]);
        dF_[k] = derivative(F_[k], n, c, C4);
    }
    for (std::size_t k = 0; k < shares_.size(); ++k)
        for (std::size_t l = 0; l < shares_.size(); ++l)
            if (shares_[l].aggregate >= 0 && shares_[k].aggregate >= shares_[l].aggregate)
                add(shares_[k].aggregate, shares_[l].aggregate, Mat6(F_[k].transpose().lazyProduct(dF_[l])));
}

void CoarseRows::add_springs() {
    for (std::size_t place = 0; place < springs_.size(); ++place) {
        const Index j = block_.touched[place];
        if (number_[place] < 0) continue;
        const Mat36 E = motion(aggregates_.arm(j));
        const bool own_row = static_cast<Index>(place) < block_.size();
        const Mat3 W = springs_of(springs_[place].v) + (own_row ? Mat3(Mat3::Identity() + form_.friction(j)) : Mat3(Mat3::Zero()));
        add(number_[place], number_[place], Mat6(E.transpose().lazyProduct(Mat36(W * E))));
    }
}

}  // namespace

SymmetricBlocks coarse_matrix(const StrainForm& form, const RigidAggregates& aggregates) {
    const CoupledRows& rows = form.rows();
    std::vector<GroupSums<BlockSum>> parts(rows.blocks.size());
    parallel_tasks(static_cast<Index>(rows.blocks.size()), [&](Index k) {
        const RowBlock& block = rows.blocks[k];
        CoarseRows coarse(form, aggregates, block, parts[k]);
        for (Index row = 0; row < block.size(); ++row) coarse.add_row(row);
        coarse.add_springs();
    });
    return coarse_blocks(aggregates.groups(), parts, [](const BlockSum& sum) { return sum.value; });
}

}  // namespace whorl
