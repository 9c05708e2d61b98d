#include <algorithm>

#include "engine/core/parallel.h"
#include "engine/models/viscosity/coupled/two_level.h"
#include "engine/models/viscosity/strain/coarse_level.h"

namespace whorl {
namespace {

using Mat6 = Eigen::Matrix<Real, 6, 6>;
using Mat36 = Eigen::Matrix<Real, 3, 6>;

/// Matrix E of a rigid motion at the arm a: E (v, omega) = v + omega x a.
Mat36 motion(const Vec3& a) {
    Mat36 E;
    E << 1, 0, 0, 0, a[2], -a[1],  //
        0, 1, 0, -a[2], 0, a[0],   //
        0, 0, 1, a[1], -a[0], 0;
    return E;
}

/// Monomials of a pair, from which all sums over a row's pairs are formed: w, w r, w r r^T, w/r^2 r r^T, and w/r^2 times the ten products
/// of three components of r. w and r as in coupled_rows.h. The last six entries are unused.
struct alignas(64) Monomials {
    static constexpr int count = 32, first = 1, second = 4, along = 10, cubes = 16;
    Real v[count] = {};
};

/// Index of the product x_a q_k among the ten, with q = (xx, yy, zz, xy, xz, yz).
constexpr int cube[3][6] = {{0, 3, 5, 1, 2, 4}, {1, 6, 8, 3, 4, 7}, {2, 7, 9, 4, 5, 8}};

[[gnu::always_inline]] inline void add_monomials(Real x, Real y, Real z, Real w, Real* __restrict sum) {
    Real m[Monomials::count] = {};
    const Real wx = w * x, wy = w * y, wz = w * z, of_r2 = 1 / (x * x + y * y + z * z);
    m[0] = w, m[1] = wx, m[2] = wy, m[3] = wz;
    m[4] = wx * x, m[5] = wy * y, m[6] = wz * z, m[7] = wx * y, m[8] = wx * z, m[9] = wy * z;
    for (int k = 0; k < 6; ++k) m[Monomials::along + k] = of_r2 * m[Monomials::second + k];
    m[16] = m[10] * x, m[17] = m[10] * y, m[18] = m[10] * z, m[19] = m[11] * x, m[20] = m[13] * z, m[21] = m[12] * x;
    m[22] = m[11] * y, m[23] = m[11] * z, m[24] = m[12] * y, m[25] = m[12] * z;
    for (int k = 0; k < Monomials::count; ++k) sum[k] += m[k];
}

Mat3 symmetric_of(const Real* m) {
    Mat3 W;
    W << m[0], m[3], m[4], m[3], m[1], m[5], m[4], m[5], m[2];
    return W;
}

/// Matrix of the cross product: crossing(a) b = a x b.
Mat3 crossing(const Vec3& a) {
    Mat3 m;
    m << 0, -a[2], a[1], a[2], 0, -a[0], -a[1], a[0], 0;
    return m;
}

/// Contribution of the particles of one aggregate to the sums of one row, for each unit rigid motion of the aggregate. The position of such
/// a particle relative to the aggregate's centre is `arm` + r, with `arm` that of the row's own particle.
struct Share {
    int aggregate;  ///< number in GroupSums; -1: neighbours without an aggregate
    Vec3 arm;
    Monomials sums{};
    Vec3 s = Vec3::Zero();         ///< sum w r
    Mat3 arm_s = Mat3::Zero();     ///< sum w arm r^T
    Mat36 b = Mat36::Zero();       ///< sum w/r^2 r q^T, with the six components q of r r^T
    Mat36 arm_b = Mat36::Zero();   ///< sum w/r^2 (arm x r) q^T
    Mat36 spring = Mat36::Zero();  ///< sum W E; W = 2 c w + 2 c' w/r^2 r r^T (strain_form.h), E = motion(arm + r)

    void unpack(const StrainCoefficients& c) {
        const Real* m = sums.v;
        s = Vec3(m[Monomials::first], m[Monomials::first + 1], m[Monomials::first + 2]);
        arm_s = arm * s.transpose() + symmetric_of(m + Monomials::second);
        for (int a = 0; a < 3; ++a)
            for (int k = 0; k < 6; ++k) b(a, k) = m[Monomials::cubes + cube[a][k]];
        arm_b = crossing(arm).lazyProduct(b);  // r x r is zero
        const Mat3 W = c.smooth * m[0] * Mat3::Identity() + c.pair * symmetric_of(m + Monomials::along);
        spring.leftCols<3>() = W;
        spring.rightCols<3>() = -W * crossing(arm) - c.smooth * crossing(s);
    }
};

/// Matrix F: sums of one row for each unit motion u. Columns: the six motions of each share. Rows 0 to 8: A = sum w u r^T, row by row; rows
/// 9 to 14: sum w/r^2 (u.r) q.
class Features {
public:
    static constexpr int rows = 15;
    void resize(std::size_t shares) {
        columns_ = 6 * shares;
        vectors_ = (columns_ + lane_count - 1) / lane_count;
        for (Column<Lanes>* c : {&value_, &derivative_})
            if (c->size() < rows * vectors_) c->resize(rows * vectors_);
        if (product_.size() < columns_ * vectors_) product_.resize(columns_ * vectors_);
        for (int k = 0; k < rows; ++k) value_[at(k, vectors_ - 1)] = Lanes{};
    }
    void set(std::size_t share, const Share& of) {
        Real* F = reinterpret_cast<Real*>(value_.data()) + 6 * share;
        const std::size_t step = vectors_ * lane_count;
        for (std::size_t k = 0; k < 9; ++k)
            for (std::size_t c = 0; c < 6; ++c) F[k * step + c] = 0;
        for (int mode = 0; mode < 3; ++mode) {
            // v = e_mode: A = e_mode s^T.   omega = e_mode: u = e_mode x arm, A = [e_mode]x sum w arm r^T.
            const int p = (mode + 1) % 3, q = (mode + 2) % 3;
            for (int k = 0; k < 3; ++k) {
                F[(3 * mode + k) * step + mode] = of.s[k];
                F[(3 * p + k) * step + 3 + mode] = -of.arm_s(q, k);
                F[(3 * q + k) * step + 3 + mode] = of.arm_s(p, k);
            }
            for (int k = 0; k < 6; ++k) {
                F[(9 + k) * step + mode] = of.b(mode, k);
                F[(9 + k) * step + 3 + mode] = of.arm_b(mode, k);
            }
        }
    }
    /// Computes F^T dE/dF, with E the row's energy (strain_form.h) without the terms of the springs, w |u_j - u_i|^2 and w/r^2 ((u_j -
    /// u_i).r)^2.
    void multiply(const RowSlice& slice, Index lane, const StrainCoefficients& of_row, bool resolved, const Mat3& P);
    /// 6x6 block of F^T dE/dF for shares k and l.
    Mat6 product(std::size_t k, std::size_t l) const {
        const Real* P = reinterpret_cast<const Real*>(product_.data()) + 6 * k * vectors_ * lane_count + 6 * l;
        Mat6 m;
        for (int r = 0; r < 6; ++r)
            for (int col = 0; col < 6; ++col) m(r, col) = P[static_cast<std::size_t>(r) * vectors_ * lane_count + col];
        return m;
    }

private:
    std::size_t at(int row, std::size_t vector) const { return static_cast<std::size_t>(row) * vectors_ + vector; }
    std::size_t columns_ = 0, vectors_ = 0;
    Column<Lanes> value_, derivative_, product_;
};

void Features::multiply(const RowSlice& slice, Index lane, const StrainCoefficients& of_row, bool resolved, const Mat3& P) {
    const SymmetricLanes inverse_moment = lanes_of(lane_of(slice.inverse_moment, lane)), resolving = lanes_of(P);
    const CoefficientLanes c{lanes_of(of_row.shear), lanes_of(of_row.bulk), lanes_of(of_row.smooth), lanes_of(of_row.pair)};
    FourthMoment fourth;
    for (int k = 0; k < 15; ++k) fourth.v[k] = lanes_of(slice.fourth.v[k][lane]);
    for (std::size_t v = 0; v < vectors_; ++v) {
        Lanes33 A;
        for (int k = 0; k < 9; ++k) A.m[k / 3][k % 3] = value_[at(k, v)];
        const auto number = [&](int k) { return value_[at(9 + k, v)]; };
        const Lanes33 G = A * inverse_moment;
        const Lanes33 Q = row_force(G, {number(0), number(1), number(2), number(3), number(4), number(5)}, c, inverse_moment, fourth,
                                    resolved, [&](const Lanes33& m) { return resolving * m; });
        for (int k = 0; k < 9; ++k) derivative_[at(k, v)] = Q.m[k / 3][k % 3];
        const Lanes g[6] = {G.m[0][0], G.m[1][1], G.m[2][2], G.m[0][1] + G.m[1][0], G.m[0][2] + G.m[2][0], G.m[1][2] + G.m[2][1]};
        for (int k = 0; k < 6; ++k) derivative_[at(9 + k, v)] = -c.pair * g[k];
    }
    const Real* F = reinterpret_cast<const Real*>(value_.data());
    for (std::size_t r = 0; r < columns_; ++r)
        for (std::size_t v = 0; v < vectors_; ++v) {
            Lanes sum{};
            for (int k = 0; k < rows; ++k) sum += F[at(k, 0) * lane_count + r] * derivative_[at(k, v)];
            product_[r * vectors_ + v] = sum;
        }
}

struct BlockSum {
    SymmetricBlocks::Block value = SymmetricBlocks::Block::Zero();
};

/// Contribution of one block of rows to Ac. The springs are the terms of the energy in which only a pair occurs, c w |u_j - u_i|^2 + c'
/// w/r^2 ((u_j - u_i).r)^2.
class CoarseRows {
public:
    CoarseRows(const StrainForm& form, const RigidAggregates& aggregates, const RowBlock& block, GroupSums<BlockSum>& sums);
    void add_rows(const RowSlice& slice);
    /// Adds the springs' terms quadratic in u_j, the mass and the friction. Call it after all add_rows().
    void add_springs();

private:
    void find_springs();
    Mat3 spring(std::size_t entry) const;  ///< sum of W over the pairs of a particle or wall
    void find_shares(const RowSlice& slice, Index lane);
    void add_coupling(Index row);
    void add_strains(const RowSlice& slice, Index lane);
    void add(int a, int b, const Mat6& m);
    /// nullptr if the entry is a particle
    const WallPoint* wall_of(RowBlock::LocalIndex at) const {
        return at < block_.touched.size() ? nullptr : &block_.walls[at - block_.touched.size()];
    }
    Mat3 sliding(const WallPoint& wall) const;
    /// Arm of a wall's point from the centre of its body, in spacings.
    Vec3 arm_of(const WallPoint& wall) const { return form_.rows().in_spacings(wall.arm); }

    const StrainForm& form_;
    const RigidAggregates& aggregates_;
    const RowBlock& block_;
    const Vec4* at_;  ///< positions of the block's touched particles
    GroupSums<BlockSum>& sums_;
    Column<Lanes> pairs_;               ///< x, y and z of r, and w, of each pair of a slice
    Column<Vec4> springs_;              ///< sum of W over the pairs of each entry of the block: xx yy zz, xy xz yz
    std::vector<int> number_;           ///< number in sums_ of the aggregate of each entry (particle or wall), -1: none
    std::vector<Share> shares_;         ///< shares of one row, that of the row's own particle first
    std::vector<std::size_t> counted_;  ///< indices of the shares that belong to an aggregate
    Features features_;
};

CoarseRows::CoarseRows(const StrainForm& form, const RigidAggregates& aggregates, const RowBlock& block, GroupSums<BlockSum>& sums)
    : form_(form), aggregates_(aggregates), block_(block), at_(form.rows().positions(block)), sums_(sums),
      springs_(2 * block.entries(), Vec4{}), number_(block.entries(), -1) {
    for (std::size_t place = 0; place < block.touched.size(); ++place) {
        const std::int32_t a = aggregates.of(block.touched[place]);
        number_[place] = a < 0 ? -1 : sums.number(a);
    }
    if (form.bodies() == nullptr) return;
    const int first_body = aggregates.groups() - static_cast<int>(form.bodies()->body.size());
    for (std::size_t k = 0; k < block.walls.size(); ++k)
        if (block.walls[k].body >= 0) number_[block.touched.size() + k] = sums.number(first_body + block.walls[k].body);
}

void CoarseRows::find_springs() {
    for (std::size_t k = 0; k < block_.slices.size(); ++k) {
        const RowSlice& slice = block_.slices[k];
        const CoefficientLanes& c = form_.coefficients(block_, k);
        SymmetricLanes own;
        const auto add = [&](std::size_t, const PairLanes& p) {
            const Lanes3& r = p.r;
            const Lanes even = c.smooth * p.w, along = c.pair * p.w / p.r2;
            const Lanes3 t = along * r;
            const SymmetricLanes W{even + t.x * r.x, even + t.y * r.y, even + t.z * r.z, t.x * r.y, t.x * r.z, t.y * r.z};
            own.xx += W.xx, own.yy += W.yy, own.zz += W.zz, own.xy += W.xy, own.xz += W.xz, own.yz += W.yz;
            scatter(W, p.other, springs_.data());
        };
        const SliceView<false> pairs = form_.rows().pairs_of(block_, slice, at_);
        pairs.each_plain(add);
        pairs.each_wall([&](std::size_t at, PairLanes p) {
            for (Index lane = 0; lane < lane_count; ++lane)
                if (const WallPoint* wall = wall_of(p.other[lane]); wall && wall->slides()) p.w[lane] = 0;
            add(at, p);
        });
        scatter(own, slice.row, springs_.data());
    }
}

void CoarseRows::add(int a, int b, const Mat6& m) {
    SymmetricBlocks::Block& to = sums_.sum(std::max(a, b), std::min(a, b)).value;
    if (a >= b) to += m.cast<double>();
    else to += m.transpose().cast<double>();
}

void CoarseRows::add_rows(const RowSlice& slice) {
    pairs_.resize(4 * static_cast<std::size_t>(slice.width));
    form_.rows().pairs_of(block_, slice, at_).each([&](std::size_t k, const PairLanes& p) {
        Lanes* to = pairs_.data() + 4 * k;
        to[0] = p.r.x, to[1] = p.r.y, to[2] = p.r.z, to[3] = p.w;
    });
    for (Index lane = 0; lane < slice.rows; ++lane) {
        const Index row = slice.row[lane];
        if (block_.count[row] == 0 && slice.walls == 0) continue;
        find_shares(slice, lane);
        if (number_[row] >= 0) add_coupling(row);
        add_strains(slice, lane);
    }
}

void CoarseRows::find_shares(const RowSlice& slice, Index lane) {
    const Index row = slice.row[lane];
    const StrainCoefficients c = form_.coefficients(block_.begin + row);
    shares_.clear();
    shares_.push_back(Share{number_[row], aggregates_.arm(block_.begin + row)});
    const Lanes* pair = pairs_.data();
    block_.each_pair(row, [&](RowBlock::LocalIndex at) {
        const int number = number_[at];
        const Vec3 r(pair[0][lane], pair[1][lane], pair[2][lane]), arm = aggregates_.arm(block_.touched[at]) - r;
        // The image of an aggregate beyond a periodic border is a separate share.
        const auto same = [&](const Share& s) { return s.aggregate == number && (number < 0 || (s.arm - arm).squaredNorm() < 1); };
        std::size_t k = 0;
        while (k < shares_.size() && !same(shares_[k])) ++k;
        if (k == shares_.size()) shares_.push_back(Share{number, arm});
        add_monomials(r[0], r[1], r[2], pair[3][lane], shares_[k].sums.v);
        pair += 4;
    });
    // Walls do not belong to an aggregate, except those of free bodies. Those on which the fluid slides are in sliding().
    for (Index k = slice.plain(); slice.walls > 0 && k < slice.width; ++k) {
        const Lanes* wall = pairs_.data() + 4 * static_cast<std::size_t>(k);
        if (!(wall[3][lane] > 0)) continue;
        const auto entry = block_.other[slice.begin + static_cast<std::size_t>(k * lane_count + lane)];
        if (wall_of(entry)->slides()) continue;
        const int number = number_[entry];
        const Vec3 arm = number < 0 ? Vec3(Vec3::Zero()) : arm_of(*wall_of(entry)) - Vec3(wall[0][lane], wall[1][lane], wall[2][lane]);
        const auto held = std::find_if(shares_.begin(), shares_.end(), [&](const Share& s) {
            return number < 0 ? s.aggregate < 0 : s.aggregate == number && (s.arm - arm).squaredNorm() < Real(1e-4);
        });
        const std::size_t at = static_cast<std::size_t>(held - shares_.begin());
        if (held == shares_.end()) shares_.push_back(Share{number, arm});
        add_monomials(wall[0][lane], wall[1][lane], wall[2][lane], wall[3][lane], shares_[at].sums.v);
    }
    for (Share& share : shares_) share.unpack(c);
}

Mat3 CoarseRows::spring(std::size_t entry) const {
    const Real *even = springs_[2 * entry].v, *mixed = springs_[2 * entry + 1].v;
    const Real six[6] = {even[0], even[1], even[2], mixed[0], mixed[1], mixed[2]};
    return symmetric_of(six);
}

/// Adds the contributions of the row's own particle i, which belongs to each pair of the row: the springs' mixed terms u_i u_j, and -u_i in
/// the sums of u_j - u_i.
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
    share.arm_b -= crossing(a).lazyProduct(b_sum);
}

void CoarseRows::add_strains(const RowSlice& slice, Index lane) {
    counted_.clear();
    for (std::size_t k = 0; k < shares_.size(); ++k)
        if (shares_[k].aggregate >= 0) counted_.push_back(k);
    if (counted_.empty()) return;
    features_.resize(counted_.size());
    for (std::size_t k = 0; k < counted_.size(); ++k) features_.set(k, shares_[counted_[k]]);
    const Index i = block_.begin + slice.row[lane];
    features_.multiply(slice, lane, form_.coefficients(i), form_.rows().neighbourhood[i].unresolved == 0, form_.rows().resolved(i));
    for (std::size_t k = 0; k < counted_.size(); ++k)
        for (std::size_t l = 0; l < counted_.size(); ++l)
            if (const int a = shares_[counted_[k]].aggregate, b = shares_[counted_[l]].aggregate; a >= b)
                add(a, b, features_.product(k, l));
}

/// Diagonal block of a pair with a wall on which the fluid slides (StrainForm::diagonal()). Its other terms are neglected in Ac.
Mat3 CoarseRows::sliding(const WallPoint& wall) const {
    const Index i = block_.begin + wall.row;
    const StrainCoefficients c = form_.coefficients(i);
    const CoupledRows& rows = form_.rows();
    const Vec3 r = rows.in_spacings(wall.position - rows.position(i)), g = wall.weight * (rows.inverse_moment(i) * r);
    const Real K = c.shear / 2, left = std::max(Real(0), 1 - g.dot(r));
    const Mat3 W = (K + c.bulk) * g * g.transpose() + (K * g.squaredNorm() + left * c.smooth * wall.weight) * Mat3::Identity() +
                   left * c.pair * wall.weight / r.squaredNorm() * r * r.transpose();
    const Mat3 C = wall.stick * Mat3::Identity() + (1 - wall.stick) * wall.normal * wall.normal.transpose();
    return C * W * C;
}

void CoarseRows::add_springs() {
    find_springs();
    for (std::size_t k = 0; k < block_.walls.size(); ++k) {
        const WallPoint& wall = block_.walls[k];
        const int own = number_[wall.row], body = number_[block_.touched.size() + k];
        if (!wall.slides() || (own < 0 && body < 0)) continue;
        const Mat3 W = sliding(wall);
        const Mat36 E = motion(aggregates_.arm(block_.begin + wall.row)), of_body = motion(arm_of(wall));
        if (own >= 0) add(own, own, Mat6(E.transpose().lazyProduct(Mat36(W * E))));
        if (body >= 0) add(body, body, Mat6(of_body.transpose().lazyProduct(Mat36(W * of_body))));
        if (own >= 0 && body >= 0) add(own, body, Mat6(-E.transpose().lazyProduct(Mat36(W * of_body))));
    }
    for (std::size_t k = 0; k < block_.walls.size(); ++k) {
        const int body = number_[block_.touched.size() + k];
        if (body < 0 || block_.walls[k].slides()) continue;
        const Mat36 E = motion(arm_of(block_.walls[k]));
        add(body, body, Mat6(E.transpose().lazyProduct(Mat36(spring(block_.touched.size() + k) * E))));
    }
    for (std::size_t place = 0; place < block_.touched.size(); ++place) {
        const Index j = block_.touched[place];
        if (number_[place] < 0) continue;
        const Mat36 E = motion(aggregates_.arm(j));
        const bool own_row = static_cast<Index>(place) < block_.size();
        const Mat3 W = spring(place) + (own_row ? Mat3(Mat3::Identity() + form_.friction(j)) : Mat3(Mat3::Zero()));
        add(number_[place], number_[place], Mat6(E.transpose().lazyProduct(Mat36(W * E))));
    }
}

}  // namespace

SymmetricBlocks coarse_matrix(const StrainForm& form, const RigidAggregates& aggregates) {
    const CoupledRows& rows = form.rows();
    const auto rows_of = [&](Index k, GroupSums<BlockSum>& sums) {
        const RowBlock& block = rows.blocks[k];
        CoarseRows coarse(form, aggregates, block, sums);
        for (const RowSlice& slice : block.slices) coarse.add_rows(slice);
        coarse.add_springs();
    };
    SymmetricBlocks Ac = coarse_blocks<BlockSum>(aggregates.groups(), static_cast<Index>(rows.blocks.size()), rows_of,
                                                 [](const BlockSum& sum) { return sum.value; });
    if (form.bodies() == nullptr) return Ac;
    int group = aggregates.groups() - static_cast<int>(form.bodies()->body.size());
    for (const auto& body : form.bodies()->body) Ac.add(group, group, body.inertia(static_cast<double>(form.spacing()))), ++group;
    return Ac;
}

}  // namespace whorl
