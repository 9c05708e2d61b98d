#include "engine/models/coupled/coarse_matrix.h"

#include <map>

#include "engine/core/parallel.h"

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

/// What the members of one aggregate add to the sums of one row, by unit rigid motion.
struct Share {
    std::int32_t aggregate = -1;
    Vec3 s;        ///< sum w r
    Mat3 arm_s;    ///< sum w arm r^T
    Mat36 b;       ///< sum w/r^2 r q^T, q = (xx, yy, zz, xy, xz, yz) of r
    Mat36 arm_b;   ///< sum w/r^2 (arm x r) q^T
    Mat36 spring;  ///< sum W E, W = 2 c w + 2 c' w/r^2 r r^T
    void clear(std::int32_t a) {
        aggregate = a;
        s.setZero(), arm_s.setZero(), b.setZero(), arm_b.setZero(), spring.setZero();
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

/// Blocks (row aggregate >= column aggregate) that one block of rows adds to Ac.
struct Partial {
    std::map<std::pair<std::int32_t, std::int32_t>, Eigen::Matrix<double, 6, 6>> blocks;
    template <class M>
    void add(std::int32_t a, std::int32_t b, const M& m) {
        const auto [at, fresh] = blocks.try_emplace({std::max(a, b), std::min(a, b)});
        if (fresh) at->second.setZero();
        if (a >= b) at->second += m.template cast<double>();
        else at->second += m.transpose().template cast<double>();
    }
};

}  // namespace

SymmetricBlocks coarse_matrix(const StrainForm& form, const RigidAggregates& aggregates) {
    const CoupledRows& rows = form.rows();
    std::vector<Partial> partials(rows.blocks.size());
    parallel_blocks(rows.size(), CoupledRows::block_size, [&](Index begin, Index end) {
        const auto number = static_cast<std::size_t>(begin / CoupledRows::block_size);
        const RowBlock& block = rows.blocks[number];
        Partial& partial = partials[number];
        std::vector<Mat3> springs(block.touched.size(), Mat3::Zero());  // sum of W over all pairs of a particle
        std::vector<Share> shares;
        std::vector<Mat15x6> F, dF;
        for (Index i = begin; i < end; ++i) {
            const std::size_t e0 = block.row_begin(i - begin), e1 = block.row_end(i - begin);
            if (e0 == e1) continue;
            const Neighbourhood& n = rows.neighbourhood[static_cast<std::size_t>(i)];
            const StrainCoefficients& c = form.coefficients(i);
            shares.clear();
            const auto share_of = [&](std::int32_t a) -> Share& {
                for (Share& s : shares)
                    if (s.aggregate == a) return s;
                shares.emplace_back().clear(a);
                return shares.back();
            };
            Vec3 s_sum = Vec3::Zero();
            Mat36 b_sum = Mat36::Zero();
            Mat3 spring_sum = Mat3::Zero();
            Mat6 C4 = Mat6::Zero();
            for (std::size_t e = e0; e < e1; ++e) {
                const Real w = block.w[e];
                if (w == 0) continue;
                const Vec3 r(block.x[e], block.y[e], block.z[e]);
                const Real wi = w / r.squaredNorm();
                Vec6 q;
                q << r[0] * r[0], r[1] * r[1], r[2] * r[2], r[0] * r[1], r[0] * r[2], r[1] * r[2];
                const Vec3 wr = w * r;
                const Mat36 b = (wi * r) * q.transpose();
                Mat3 W = (c.pair * wi * r) * r.transpose();
                W.diagonal().array() += c.smooth * w;
                C4 += (wi * q) * q.transpose();
                s_sum += wr;
                b_sum += b;
                spring_sum += W;
                const auto place = static_cast<std::size_t>(block.other[e]);
                const auto j = static_cast<std::size_t>(block.touched[place]);
                if (aggregates.of(static_cast<Index>(j)) < 0) continue;
                springs[place] += W;
                Share& share = share_of(aggregates.of(static_cast<Index>(j)));
                share.s += wr;
                share.arm_s += aggregates.arm(static_cast<Index>(j)) * wr.transpose();
                share.b += b;
                share.arm_b += (wi * aggregates.arm(static_cast<Index>(j)).cross(r)) * q.transpose();
                share.spring += W.lazyProduct(motion(aggregates.arm(static_cast<Index>(j))));
            }
            const std::int32_t own = aggregates.of(i);
            if (own >= 0) {
                const Vec3& a = aggregates.arm(i);
                springs[static_cast<std::size_t>(i - begin)] += spring_sum;
                const Mat36 E = motion(a);
                share_of(own);
                for (const Share& share : shares) {
                    const Mat6 coupling = -E.transpose().lazyProduct(share.spring);
                    partial.add(own, share.aggregate, coupling);
                    if (share.aggregate == own) partial.add(own, own, Mat6(coupling.transpose()));
                }
                Share& share = share_of(own);
                share.s -= s_sum;
                share.arm_s -= a * s_sum.transpose();
                share.b -= b_sum;
                for (int k = 0; k < 6; ++k) share.arm_b.col(k) -= a.cross(Vec3(b_sum.col(k)));
            }
            F.resize(shares.size()), dF.resize(shares.size());
            for (std::size_t k = 0; k < shares.size(); ++k) {
                F[k] = features(shares[k]);
                dF[k] = derivative(F[k], n, c, C4);
            }
            for (std::size_t k = 0; k < shares.size(); ++k)
                for (std::size_t l = 0; l < shares.size(); ++l)
                    if (shares[k].aggregate >= shares[l].aggregate)
                        partial.add(shares[k].aggregate, shares[l].aggregate, Mat6(F[k].transpose().lazyProduct(dF[l])));
        }
        for (std::size_t place = 0; place < springs.size(); ++place) {
            const auto j = static_cast<std::size_t>(block.touched[place]);
            if (aggregates.of(static_cast<Index>(j)) < 0) continue;
            const Mat36 E = motion(aggregates.arm(static_cast<Index>(j)));
            const bool own_row = static_cast<Index>(place) < block.size();
            const Mat3 W = springs[place] + (own_row ? Mat3(Mat3::Identity() + form.friction(static_cast<Index>(j))) : Mat3(Mat3::Zero()));
            partial.add(aggregates.of(static_cast<Index>(j)), aggregates.of(static_cast<Index>(j)), Mat6(E.transpose().lazyProduct(Mat36(W * E))));
        }
    });

    SymmetricBlocks Ac(aggregates.groups());
    for (const Partial& partial : partials)
        for (const auto& [at, m] : partial.blocks) Ac.add(at.first, at.second, m);
    // An aggregate of a single particle or of a straight file has motions that move nothing: a trace of the largest entry keeps Ac definite.
    for (int a = 0; a < Ac.nodes(); ++a) {
        double largest = 0;
        for (const SymmetricBlocks::Entry& e : Ac.row(a))
            if (e.column == a) largest = e.value.diagonal().maxCoeff();
        Ac.add(a, a, (largest > 0 ? 1e-7 * largest : 1) * SymmetricBlocks::Block::Identity());
    }
    return Ac;
}

}  // namespace whorl
