#include "engine/models/coupled/strain_form.h"

#include <array>

#include "engine/core/parallel.h"

namespace whorl {
namespace {

/// Memory of one block while its rows are run through.
struct RowScratch {
    Column<Vec4> u;           ///< velocities of the touched particles
    Column<Real> du, dv, dw;  ///< u_j - u_i of each pair of a row
    Column<Real> t;           ///< 2 c' w/r^2 (u_ij.r - r.G r)
    Column<Real> fx, fy, fz;  ///< force on j
    void resize(std::size_t touched, std::size_t longest_row) {
        if (u.size() < touched) u.resize(touched);
        if (du.size() < longest_row) {
            for (Column<Real>* c : {&du, &dv, &dw, &t, &fx, &fy, &fz}) c->resize(longest_row);
        }
    }
};

RowScratch& scratch(const RowBlock& block, const CoupledRows& rows) {
    thread_local RowScratch memory;
    memory.resize(block.touched.size(), rows.longest_row);
    return memory;
}

/// The pairs of one row, as pointers that the compiler may assume to be distinct.
struct RowView {
    const Real* __restrict x, * __restrict y, * __restrict z, * __restrict w;
    const Index* __restrict other;
    Index count;
    RowView(const RowBlock& b, Index row) {
        const std::size_t at = b.row_begin(row);
        x = b.x.data() + at, y = b.y.data() + at, z = b.z.data() + at, w = b.w.data() + at;
        other = b.other.data() + at;
        count = static_cast<Index>(b.row_end(row) - at);
    }
};

using Quad = Real __attribute__((vector_size(4 * sizeof(Real))));

const Quad& quad(const Real* from) { return *reinterpret_cast<const Quad*>(from); }
Quad& quad(Real* to) { return *reinterpret_cast<Quad*>(to); }

/// u_j - u_i of each pair, and A = sum w (u_j - u_i) r^T.
Mat3 differences(const RowView& row, const Vec4* __restrict u, Index own, RowScratch& s) {
    Real* __restrict du = s.du.data(), * __restrict dv = s.dv.data(), * __restrict dw = s.dw.data();
    const Quad of_own = quad(u[own].v);
    static_assert(CoupledRows::lanes % 4 == 0);
    for (Index e = 0; e < row.count; e += 4) {
        // Four pairs' (x, y, z, 0) become four pairs' x, y, z.
        const Quad a = quad(u[row.other[e]].v) - of_own, b = quad(u[row.other[e + 1]].v) - of_own;
        const Quad c = quad(u[row.other[e + 2]].v) - of_own, d = quad(u[row.other[e + 3]].v) - of_own;
        const Quad xy0 = __builtin_shufflevector(a, b, 0, 4, 1, 5), xy1 = __builtin_shufflevector(c, d, 0, 4, 1, 5);
        quad(du + e) = __builtin_shufflevector(xy0, xy1, 0, 1, 4, 5);
        quad(dv + e) = __builtin_shufflevector(xy0, xy1, 2, 3, 6, 7);
        quad(dw + e) =
            __builtin_shufflevector(__builtin_shufflevector(a, b, 2, 6, 2, 6), __builtin_shufflevector(c, d, 2, 6, 2, 6), 0, 1, 4, 5);
    }
    Real a00 = 0, a01 = 0, a02 = 0, a10 = 0, a11 = 0, a12 = 0, a20 = 0, a21 = 0, a22 = 0;
    for (Index e = 0; e < row.count; ++e) {
        const Real wx = row.w[e] * row.x[e], wy = row.w[e] * row.y[e], wz = row.w[e] * row.z[e];
        a00 += du[e] * wx, a01 += du[e] * wy, a02 += du[e] * wz;
        a10 += dv[e] * wx, a11 += dv[e] * wy, a12 += dv[e] * wz;
        a20 += dw[e] * wx, a21 += dw[e] * wy, a22 += dw[e] * wz;
    }
    Mat3 A;
    A << a00, a01, a02, a10, a11, a12, a20, a21, a22;
    return A;
}

/// t = pair w/r^2 ((u_j - u_i).r - r.D r) of each pair, and H = sum t r r^T. These loops are functions of their own so that the compiler
/// believes their pointers to be distinct.
Mat3 along_pairs(const RowView row, const Mat3& D, Real pair, const Real* __restrict du, const Real* __restrict dv,
                 const Real* __restrict dw, Real* __restrict ts) {
    const Real d00 = D(0, 0), d11 = D(1, 1), d22 = D(2, 2), d01 = 2 * D(0, 1), d02 = 2 * D(0, 2), d12 = 2 * D(1, 2);
    Real h00 = 0, h11 = 0, h22 = 0, h01 = 0, h02 = 0, h12 = 0;
    for (Index e = 0; e < row.count; ++e) {
        const Real rx = row.x[e], ry = row.y[e], rz = row.z[e];
        const Real xx = rx * rx, yy = ry * ry, zz = rz * rz, xy = rx * ry, xz = rx * rz, yz = ry * rz;
        const Real along = du[e] * rx + dv[e] * ry + dw[e] * rz;
        const Real linear = d00 * xx + d11 * yy + d22 * zz + d01 * xy + d02 * xz + d12 * yz;
        const Real t = pair * row.w[e] / (xx + yy + zz) * (along - linear);
        ts[e] = t;
        h00 += t * xx, h11 += t * yy, h22 += t * zz, h01 += t * xy, h02 += t * xz, h12 += t * yz;
    }
    Mat3 H;
    H << h00, h01, h02, h01, h11, h12, h02, h12, h22;
    return H;
}

/// f = Q w r + smooth w (u_j - u_i) + t r of each pair.
void pair_forces(const RowView row, const Mat3& Q, Real smooth, const Real* __restrict du, const Real* __restrict dv,
                 const Real* __restrict dw, const Real* __restrict ts, Real* __restrict fx, Real* __restrict fy, Real* __restrict fz) {
    const Real q00 = Q(0, 0), q01 = Q(0, 1), q02 = Q(0, 2), q10 = Q(1, 0), q11 = Q(1, 1), q12 = Q(1, 2);
    const Real q20 = Q(2, 0), q21 = Q(2, 1), q22 = Q(2, 2);
    for (Index e = 0; e < row.count; ++e) {
        const Real w = row.w[e], cw = smooth * w, t = ts[e];
        const Real rx = row.x[e], ry = row.y[e], rz = row.z[e];
        fx[e] = w * (q00 * rx + q01 * ry + q02 * rz) + cw * du[e] + t * rx;
        fy[e] = w * (q10 * rx + q11 * ry + q12 * rz) + cw * dv[e] + t * ry;
        fz[e] = w * (q20 * rx + q21 * ry + q22 * rz) + cw * dw[e] + t * rz;
    }
}

/// f = Q w r of each pair.
void pair_forces(const RowView row, const Mat3& Q, Real* __restrict fx, Real* __restrict fy, Real* __restrict fz) {
    const Real q00 = Q(0, 0), q01 = Q(0, 1), q02 = Q(0, 2), q10 = Q(1, 0), q11 = Q(1, 1), q12 = Q(1, 2);
    const Real q20 = Q(2, 0), q21 = Q(2, 1), q22 = Q(2, 2);
    for (Index e = 0; e < row.count; ++e) {
        const Real wx = row.w[e] * row.x[e], wy = row.w[e] * row.y[e], wz = row.w[e] * row.z[e];
        fx[e] = q00 * wx + q01 * wy + q02 * wz;
        fy[e] = q10 * wx + q11 * wy + q12 * wz;
        fz[e] = q20 * wx + q21 * wy + q22 * wz;
    }
}

/// Adds the row's forces on its neighbours, s.f of each pair, to out, and their opposite to the row's own particle.
void scatter(const RowView row, Index own, const RowScratch& s, Vec4* __restrict out) {
    const Real* __restrict fx = s.fx.data(), * __restrict fy = s.fy.data(), * __restrict fz = s.fz.data();
    const Quad none = {0, 0, 0, 0};
    Quad sum_x = none, sum_y = none, sum_z = none;
    for (Index e = 0; e < row.count; e += 4) {
        // Four pairs' x, y, z become four pairs' (x, y, z, 0).
        const Quad x = quad(fx + e), y = quad(fy + e), z = quad(fz + e);
        const Quad xy0 = __builtin_shufflevector(x, y, 0, 4, 1, 5), xy1 = __builtin_shufflevector(x, y, 2, 6, 3, 7);
        const Quad z0 = __builtin_shufflevector(z, none, 0, 4, 1, 5), z1 = __builtin_shufflevector(z, none, 2, 6, 3, 7);
        quad(out[row.other[e]].v) += __builtin_shufflevector(xy0, z0, 0, 1, 4, 5);
        quad(out[row.other[e + 1]].v) += __builtin_shufflevector(xy0, z0, 2, 3, 6, 7);
        quad(out[row.other[e + 2]].v) += __builtin_shufflevector(xy1, z1, 0, 1, 4, 5);
        quad(out[row.other[e + 3]].v) += __builtin_shufflevector(xy1, z1, 2, 3, 6, 7);
        sum_x += x, sum_y += y, sum_z += z;
    }
    const auto all = [](const Quad& q) { return (q[0] + q[2]) + (q[1] + q[3]); };
    quad(out[own].v) -= Quad{all(sum_x), all(sum_y), all(sum_z), 0};
}

Mat3 symmetric(const Mat3& A) { return Real(0.5) * (A + A.transpose()); }

/// dE/dG of the strain and bulk terms.
Mat3 stress(const Mat3& G, const Neighbourhood& n, const StrainCoefficients& c) {
    if (n.unresolved == 0) {
        Mat3 S = c.shear * symmetric(G);
        S.diagonal().array() += c.bulk * G.trace();
        return S;
    }
    const Mat3 D = symmetric(n.resolved * G);
    Mat3 S = c.shear * D;
    S.diagonal().array() += c.bulk * D.trace();
    return n.resolved * S;
}

}  // namespace

void StrainForm::set(const CoupledRows& rows, Span<const Real> viscosity, Span<const Real> counted, Real dt, Real density, Real spacing,
                     const CoupledOptions& o) {
    rows_ = &rows;
    friction_ = {};
    spacing_ = spacing;
    coefficients_.resize(rows.size());
    parallel_for(rows.size(), [&](Index i) {
        const Neighbourhood& n = rows.neighbourhood[i];
        const double K = double(viscosity[i]) * dt / (double(density) * spacing * spacing);
        StrainCoefficients& c = coefficients_[i];
        const double sheared = counted.empty() ? K : (1 - counted[i]) * K;
        c.shear = static_cast<Real>(2 * sheared);
        c.bulk = static_cast<Real>(2 * K * o.bulk / (2 + n.unresolved * o.bulk));
        const double base = n.spread > 0 ? 2 * 3 / n.spread : 0;
        c.smooth = static_cast<Real>(base * (sheared * o.smoothing));
        c.pair = static_cast<Real>(base * (sheared * o.pair_smoothing));
    });
    forces_.resize(rows.entries());
}

void StrainForm::apply(Span<const Vec3> u, Span<Vec3> y) const {
    const CoupledRows& rows = *rows_;
    parallel_blocks(rows.size(), CoupledRows::block_size, [&](Index begin, Index) {
        const RowBlock& block = rows.blocks[begin / CoupledRows::block_size];
        RowScratch& s = scratch(block, rows);
        Vec4* out = forces_.data() + block.place;
        for (std::size_t l = 0; l < block.touched.size(); ++l) {
            const Vec3& v = u[block.touched[l]];
            s.u[l] = {{v[0], v[1], v[2], 0}};
            out[l] = {{0, 0, 0, 0}};
        }
        for (Index own = 0; own < block.size(); ++own) {
            const RowView row(block, own);
            if (row.count == 0) continue;
            const auto i = static_cast<std::size_t>(block.begin + own);
            const Neighbourhood& n = rows.neighbourhood[i];
            const StrainCoefficients& c = coefficients_[i];
            const Mat3 A = differences(row, s.u.data(), own, s);
            const Mat3 G = A * n.inverse_moment;
            const Mat3 D = symmetric(G);

            const Mat3 H = along_pairs(row, D, c.pair, s.du.data(), s.dv.data(), s.dw.data(), s.t.data());

            // Force on j: Q w r + 2 c w (u_j - u_i) + t r,  Q = (P S - H) M+ - 2 c G
            const Mat3 Q = (stress(G, n, c) - H) * n.inverse_moment - c.smooth * G;
            pair_forces(row, Q, c.smooth, s.du.data(), s.dv.data(), s.dw.data(), s.t.data(), s.fx.data(), s.fy.data(), s.fz.data());
            scatter(row, own, s, out);
        }
    });
    rows.gather<Vec4>(forces_, [&](Index i, const Vec4& f) {
        y[i] = u[i] + Vec3(f.v[0], f.v[1], f.v[2]);
        if (!friction_.empty()) y[i] += friction_[i] * u[i];
    });
}

void StrainForm::add_stress(Span<const Real> q, Span<const Mat3> T, Span<Vec3> y) const {
    const CoupledRows& rows = *rows_;
    parallel_blocks(rows.size(), CoupledRows::block_size, [&](Index begin, Index) {
        const RowBlock& block = rows.blocks[begin / CoupledRows::block_size];
        RowScratch& s = scratch(block, rows);
        Vec4* out = forces_.data() + block.place;
        std::fill(out, out + block.touched.size(), Vec4{{0, 0, 0, 0}});
        for (Index own = 0; own < block.size(); ++own) {
            const RowView row(block, own);
            const auto i = static_cast<std::size_t>(block.begin + own);
            if (row.count == 0) continue;
            const Neighbourhood& n = rows.neighbourhood[i];
            Mat3 stress = q[i] * Mat3::Identity();
            if (!T.empty()) stress += coefficients_[i].shear * spacing_ * T[i];
            const Mat3 Q = n.resolved * stress * n.inverse_moment;
            pair_forces(row, Q, s.fx.data(), s.fy.data(), s.fz.data());
            scatter(row, own, s, out);
        }
    });
    rows.gather<Vec4>(forces_, [&](Index i, const Vec4& f) { y[i] += Vec3(f.v[0], f.v[1], f.v[2]); });
}

void velocity_gradients(const CoupledRows& rows, Real spacing, Span<const Vec3> u, Span<Mat3> G) {
    parallel_blocks(rows.size(), CoupledRows::block_size, [&](Index begin, Index) {
        const RowBlock& block = rows.blocks[begin / CoupledRows::block_size];
        RowScratch& s = scratch(block, rows);
        for (std::size_t l = 0; l < block.touched.size(); ++l) {
            const Vec3& v = u[block.touched[l]];
            s.u[l] = {{v[0], v[1], v[2], 0}};
        }
        for (Index own = 0; own < block.size(); ++own) {
            const auto i = static_cast<std::size_t>(block.begin + own);
            G[i] = differences(RowView(block, own), s.u.data(), own, s) * rows.neighbourhood[i].inverse_moment / spacing;
        }
    });
}

Real StrainForm::divergence(Index i, const Mat3& G) const {
    const Neighbourhood& n = rows_->neighbourhood[i];
    return n.unresolved == 0 ? G.trace() : (n.resolved * G).trace();
}

namespace {

/// The blocks (xx, yy, zz, xy, xz, yz) that a row adds to its neighbours, and sum g.
Vec3 neighbour_blocks(const RowView row, const Mat3& M, const StrainCoefficients& c, std::array<Column<Real>, 6>& p) {
    const Real K = c.shear / 2, outer = K + c.bulk;
    Real* __restrict p0 = p[0].data(), * __restrict p1 = p[1].data(), * __restrict p2 = p[2].data();
    Real* __restrict p3 = p[3].data(), * __restrict p4 = p[4].data(), * __restrict p5 = p[5].data();
    const Real m00 = M(0, 0), m11 = M(1, 1), m22 = M(2, 2), m01 = M(0, 1), m02 = M(0, 2), m12 = M(1, 2);
    const Real smooth = c.smooth, pair = c.pair;
    Real s0 = 0, s1 = 0, s2 = 0;
    for (Index e = 0; e < row.count; ++e) {
        const Real x = row.x[e], y = row.y[e], z = row.z[e], w = row.w[e];
        const Real g0 = w * (m00 * x + m01 * y + m02 * z), g1 = w * (m01 * x + m11 * y + m12 * z), g2 = w * (m02 * x + m12 * y + m22 * z);
        const Real left = std::max(Real(0), 1 - (g0 * x + g1 * y + g2 * z));
        const Real pw = left * pair * w / (x * x + y * y + z * z);
        const Real round = K * (g0 * g0 + g1 * g1 + g2 * g2) + left * smooth * w;
        p0[e] = outer * g0 * g0 + round + pw * x * x;
        p1[e] = outer * g1 * g1 + round + pw * y * y;
        p2[e] = outer * g2 * g2 + round + pw * z * z;
        p3[e] = outer * g0 * g1 + pw * x * y;
        p4[e] = outer * g0 * g2 + pw * x * z;
        p5[e] = outer * g1 * g2 + pw * y * z;
        s0 += g0, s1 += g1, s2 += g2;
    }
    return Vec3(s0, s1, s2);
}

}  // namespace

// With g = M+ w r the block of j gets from row i  K (1 + Lambda) g g^T + K |g|^2  and the penalties' 2 w (1 - g.r)(c + c' r r^T / r^2),
// where the last r r^T stands for a fourth moment. The block of i gets the first with -h for g, h = sum g, and 2 w ((1 - h.r) c + (1 -
// h.r)^2 c' r r^T / r^2).
void StrainForm::diagonal(Span<Mat3> B) const {
    const CoupledRows& rows = *rows_;
    struct alignas(8 * sizeof(Real)) Symmetric {
        Real v[8] = {};  ///< xx yy zz xy xz yz
    };
    static_assert(sizeof(Symmetric) == 8 * sizeof(Real));
    Column<Symmetric> parts(rows.entries());
    parallel_blocks(rows.size(), CoupledRows::block_size, [&](Index begin, Index) {
        const RowBlock& block = rows.blocks[begin / CoupledRows::block_size];
        Symmetric* out = parts.data() + block.place;
        thread_local struct { std::array<Column<Real>, 6> p; } block_scratch;
        for (Column<Real>& p : block_scratch.p) p.resize(std::max(p.size(), rows.longest_row));
        for (Index own = 0; own < block.size(); ++own) {
            const RowView row(block, own);
            if (row.count == 0) continue;
            const auto i = static_cast<std::size_t>(block.begin + own);
            const Mat3& M = rows.neighbourhood[i].inverse_moment;
            const StrainCoefficients& c = coefficients_[i];
            const Real K = c.shear / 2, outer = K + c.bulk;
            const Vec3 sum = neighbour_blocks(row, M, c, block_scratch.p);
            const Real* __restrict p0 = block_scratch.p[0].data(), * __restrict p1 = block_scratch.p[1].data();
            const Real* __restrict p2 = block_scratch.p[2].data(), * __restrict p3 = block_scratch.p[3].data();
            const Real* __restrict p4 = block_scratch.p[4].data(), * __restrict p5 = block_scratch.p[5].data();
            for (Index e = 0; e < row.count; ++e) {
                Real* o = out[row.other[e]].v;
                o[0] += p0[e], o[1] += p1[e], o[2] += p2[e], o[3] += p3[e], o[4] += p4[e], o[5] += p5[e];
            }
            Real self[6] = {0, 0, 0, 0, 0, 0};
            for (Index e = 0; e < row.count; ++e) {
                const Real x = row.x[e], y = row.y[e], z = row.z[e], w = row.w[e];
                const Real left = 1 - (sum[0] * x + sum[1] * y + sum[2] * z);
                const Real cw = c.smooth * w * left, pw = c.pair * w * left * left / (x * x + y * y + z * z);
                self[0] += cw + pw * x * x, self[1] += cw + pw * y * y, self[2] += cw + pw * z * z;
                self[3] += pw * x * y, self[4] += pw * x * z, self[5] += pw * y * z;
            }
            const Real round = K * (sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]);
            Real* o = out[own].v;
            o[0] += outer * sum[0] * sum[0] + round + self[0];
            o[1] += outer * sum[1] * sum[1] + round + self[1];
            o[2] += outer * sum[2] * sum[2] + round + self[2];
            o[3] += outer * sum[0] * sum[1] + self[3];
            o[4] += outer * sum[0] * sum[2] + self[4];
            o[5] += outer * sum[1] * sum[2] + self[5];
        }
    });
    rows.gather<Symmetric>(parts, [&](Index i, const Symmetric& p) {
        Mat3& b = B[i];
        b << 1 + p.v[0], p.v[3], p.v[4], p.v[3], 1 + p.v[1], p.v[5], p.v[4], p.v[5], 1 + p.v[2];
        b += friction(i);
    });
}

}  // namespace whorl
