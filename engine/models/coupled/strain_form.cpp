#include "engine/models/coupled/strain_form.h"

#include "engine/core/parallel.h"

namespace whorl {
namespace {

/// Memory of one block while its rows are run through.
struct RowScratch {
    Column<Vec4> u;           ///< velocities of the touched particles
    Column<Lanes3> velocity;  ///< u_j - u_i of each pair of a slice
    Column<Lanes> stiffness;  ///< w/r^2 of each pair
};

RowScratch& scratch(const RowBlock& block, const CoupledRows& rows) {
    thread_local RowScratch memory;
    const auto width = static_cast<std::size_t>(rows.widest_slice);
    if (memory.u.size() < block.touched.size()) memory.u.resize(block.touched.size());
    if (memory.velocity.size() < width) memory.velocity.resize(width), memory.stiffness.resize(width);
    return memory;
}

/// The velocities of the particles that a block touches.
void take_velocities(const RowBlock& block, Span<const Vec3> u, RowScratch& s) {
    for (std::size_t l = 0; l < block.touched.size(); ++l) {
        const Vec3& v = u[block.touched[l]];
        s.u[l] = {{v[0], v[1], v[2], 0}};
    }
}

/// What a row's pairs sum up to.
struct PairSums {
    Lanes33 A{};             ///< sum w (u_j - u_i) r^T
    SymmetricLanes along{};  ///< sum w/r^2 ((u_j - u_i).r) r r^T
};

/// Keeps u_j - u_i and w/r^2 of each pair in the scratch.
PairSums sum_pairs(const SliceView& pairs, const Lanes3& own, RowScratch& s) {
    PairSums sum;
    const Vec4* u = s.u.data();
    pairs.each([&](std::size_t k, const Lanes3& r, const Lanes& w, const Index* other) {
        const Lanes3 v = gather(u, other) - own;
        s.velocity[k] = v;
        const Lanes3 wr = w * r;
        auto& A = sum.A.m;
        A[0][0] += v.x * wr.x, A[0][1] += v.x * wr.y, A[0][2] += v.x * wr.z;
        A[1][0] += v.y * wr.x, A[1][1] += v.y * wr.y, A[1][2] += v.y * wr.z;
        A[2][0] += v.z * wr.x, A[2][1] += v.z * wr.y, A[2][2] += v.z * wr.z;
        const Lanes xx = r.x * r.x, yy = r.y * r.y, zz = r.z * r.z;
        const Lanes stiffness = w / (xx + yy + zz);
        s.stiffness[k] = stiffness;
        const Lanes t = stiffness * dot(v, r), tx = t * r.x, ty = t * r.y;
        SymmetricLanes& B = sum.along;
        B.xx += t * xx, B.yy += t * yy, B.zz += t * zz, B.xy += tx * r.y, B.xz += tx * r.z, B.yz += ty * r.z;
    });
    return sum;
}

/// A alone.
Lanes33 sum_differences(const SliceView& pairs, const Lanes3& own, const Vec4* u) {
    Lanes33 sum{};
    pairs.each([&](std::size_t, const Lanes3& r, const Lanes& w, const Index* other) {
        const Lanes3 v = gather(u, other) - own, wr = w * r;
        auto& A = sum.m;
        A[0][0] += v.x * wr.x, A[0][1] += v.x * wr.y, A[0][2] += v.x * wr.z;
        A[1][0] += v.y * wr.x, A[1][1] += v.y * wr.y, A[1][2] += v.y * wr.z;
        A[2][0] += v.z * wr.x, A[2][1] += v.z * wr.y, A[2][2] += v.z * wr.z;
    });
    return sum;
}

/// sum w/r^2 (r.D r) r r^T
SymmetricLanes contract(const FourthMoment& f, const SymmetricLanes& D) {
    const Lanes g[6] = {D.xx, D.yy, D.zz, D.xy + D.xy, D.xz + D.xz, D.yz + D.yz};
    const auto number = [&](int k) {
        Lanes sum = f.of(k, 0) * g[0];
        for (int l = 1; l < 6; ++l) sum += f.of(k, l) * g[l];
        return sum;
    };
    return {number(0), number(1), number(2), number(3), number(4), number(5)};
}

/// P (2 K D + K Lambda tr D), D of the resolved directions: dE/dG of the strain and bulk terms. @param resolved_of resolved_of(m) is P m of
/// each lane
template <class Resolved>
Lanes33 stress(const Lanes33& G, const CoefficientLanes& c, bool resolved, const Resolved& resolved_of) {
    const auto of = [&](const SymmetricLanes& D) {
        const Lanes volume = c.bulk * (D.xx + D.yy + D.zz);
        return whole(
            {c.shear * D.xx + volume, c.shear * D.yy + volume, c.shear * D.zz + volume, c.shear * D.xy, c.shear * D.xz, c.shear * D.yz});
    };
    if (resolved) return of(symmetric(G));
    Lanes33 S = of(symmetric(resolved_of(G)));
    return resolved_of(S);
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
    by_slice_.resize(rows.slices);
    parallel_for(static_cast<Index>(rows.blocks.size()), [&](Index b) {
        const RowBlock& block = rows.blocks[b];
        for (std::size_t k = 0; k < block.slices.size(); ++k)
            for (Index lane = 0; lane < lane_count; ++lane) {
                const StrainCoefficients& c = coefficients_[block.begin + block.slices[k].row[lane]];
                CoefficientLanes& to = by_slice_[block.first_slice + k];
                to.shear[lane] = c.shear, to.bulk[lane] = c.bulk, to.smooth[lane] = c.smooth, to.pair[lane] = c.pair;
            }
    });
}

void StrainForm::find_forces(Span<const Vec3> u) const {
    const CoupledRows& rows = *rows_;
    parallel_blocks(rows.size(), CoupledRows::block_size, [&](Index begin, Index) {
        const RowBlock& block = rows.blocks[begin / CoupledRows::block_size];
        RowScratch& s = scratch(block, rows);
        Vec4* out = forces_.data() + block.place;
        take_velocities(block, u, s);
        std::fill(out, out + block.touched.size(), Vec4{{0, 0, 0, 0}});
        for (std::size_t k = 0; k < block.slices.size(); ++k) {
            const RowSlice& slice = block.slices[k];
            const CoefficientLanes& c = coefficients(block, k);
            const SliceView pairs(block, slice);
            const PairSums sum = sum_pairs(pairs, gather(s.u.data(), slice.row), s);
            const Lanes33 G = sum.A * slice.inverse_moment;
            const SymmetricLanes D = symmetric(G);

            // H = sum t r r^T, t = 2 c' w/r^2 ((u_j - u_i).r - r.D r)
            const SymmetricLanes linear = contract(slice.fourth, D), &all = sum.along;
            const SymmetricLanes H{c.pair * (all.xx - linear.xx), c.pair * (all.yy - linear.yy), c.pair * (all.zz - linear.zz),
                                   c.pair * (all.xy - linear.xy), c.pair * (all.xz - linear.xz), c.pair * (all.yz - linear.yz)};

            // Force on j: Q w r + 2 c w (u_j - u_i) + t r,  Q = (P S - H) M+ - 2 c G
            Lanes33 Q = stress(G, c, slice.resolved, [&](const Lanes33& m) { return resolved_part(block, slice, m); });
            const Lanes33 along = whole(H);
            for (int a = 0; a < 3; ++a)
                for (int b = 0; b < 3; ++b) Q.m[a][b] -= along.m[a][b];
            Q = Q * slice.inverse_moment;
            for (int a = 0; a < 3; ++a)
                for (int b = 0; b < 3; ++b) Q.m[a][b] -= c.smooth * G.m[a][b];
            Lanes3 total{};
            pairs.each([&](std::size_t e, const Lanes3& r, const Lanes& w, const Index* other) {
                const Lanes3& v = s.velocity[e];
                const Lanes t = c.pair * s.stiffness[e] * (dot(v, r) - dot(r, D * r));
                const Lanes3 f = w * (Q * r + c.smooth * v) + t * r;
                total = total + f;
                scatter(f, other, out);
            });
            scatter(Lanes3{-total.x, -total.y, -total.z}, slice.row, out);
        }
    });
}

void StrainForm::apply(Span<const Vec3> u, Span<Vec3> y) const {
    find_forces(u);
    parallel_for(rows_->size(), [&](Index i) { y[i] = applied(u, i); });
}

/// P m of each lane.
Lanes33 StrainForm::resolved_part(const RowBlock& block, const RowSlice& slice, const Lanes33& m) const {
    Lanes33 product;
    for (Index lane = 0; lane < lane_count; ++lane)
        set_lane(product, lane, rows_->neighbourhood[block.begin + slice.row[lane]].resolved * lane_of(m, lane));
    return product;
}

void StrainForm::add_stress(Span<const Real> q, Span<const Mat3> T, Span<Vec3> y) const {
    const CoupledRows& rows = *rows_;
    parallel_blocks(rows.size(), CoupledRows::block_size, [&](Index begin, Index) {
        const RowBlock& block = rows.blocks[begin / CoupledRows::block_size];
        Vec4* out = forces_.data() + block.place;
        std::fill(out, out + block.touched.size(), Vec4{{0, 0, 0, 0}});
        for (const RowSlice& slice : block.slices) {
            Lanes33 Q;
            for (Index lane = 0; lane < lane_count; ++lane) {
                const auto i = static_cast<std::size_t>(block.begin + slice.row[lane]);
                const Neighbourhood& n = rows.neighbourhood[i];
                Mat3 stress = q[i] * Mat3::Identity();
                if (!T.empty()) stress += coefficients_[i].shear * spacing_ * T[i];
                set_lane(Q, lane, n.resolved * stress * n.inverse_moment);
            }
            Lanes3 total{};
            SliceView(block, slice).each([&](std::size_t, const Lanes3& r, const Lanes& w, const Index* other) {
                const Lanes3 f = w * (Q * r);
                total = total + f;
                scatter(f, other, out);
            });
            scatter(Lanes3{-total.x, -total.y, -total.z}, slice.row, out);
        }
    });
    parallel_for(rows.size(), [&](Index i) {
        const Vec4 f = rows.gathered<Vec4>(forces_, i);
        y[i] += Vec3(f.v[0], f.v[1], f.v[2]);
    });
}

void velocity_gradients(const CoupledRows& rows, Real spacing, Span<const Vec3> u, Span<Mat3> G) {
    parallel_blocks(rows.size(), CoupledRows::block_size, [&](Index begin, Index) {
        const RowBlock& block = rows.blocks[begin / CoupledRows::block_size];
        RowScratch& s = scratch(block, rows);
        take_velocities(block, u, s);
        const Lanes per_metre = lanes_of(1 / spacing);
        for (const RowSlice& slice : block.slices) {
            Lanes33 A = sum_differences(SliceView(block, slice), gather(s.u.data(), slice.row), s.u.data());
            for (auto& row : A.m)
                for (Lanes& v : row) v *= per_metre;
            const Lanes33 gradient = A * slice.inverse_moment;
            for (Index lane = 0; lane < slice.rows; ++lane) G[block.begin + slice.row[lane]] = lane_of(gradient, lane);
        }
    });
}

Real StrainForm::divergence(Index i, const Mat3& G) const {
    const Neighbourhood& n = rows_->neighbourhood[i];
    return n.unresolved == 0 ? G.trace() : (n.resolved * G).trace();
}

// With g = M+ w r the block of j gets from row i  K (1 + Lambda) g g^T + K |g|^2  and the penalties' 2 w (1 - g.r)(c + c' r r^T / r^2),
// where the last r r^T stands for a fourth moment. The block of i gets the first with -h for g, h = sum g, and 2 w ((1 - h.r) c + (1 -
// h.r)^2 c' r r^T / r^2).
void StrainForm::diagonal(Span<Mat3> B) const {
    const CoupledRows& rows = *rows_;
    // xx yy zz in the first, xy xz yz in the second
    struct alignas(2 * sizeof(Vec4)) Symmetric {
        Real v[8] = {};
    };
    static_assert(sizeof(Symmetric) == 2 * sizeof(Vec4));
    Column<Symmetric> parts(rows.entries());
    parallel_blocks(rows.size(), CoupledRows::block_size, [&](Index begin, Index) {
        const RowBlock& block = rows.blocks[begin / CoupledRows::block_size];
        Vec4* out = reinterpret_cast<Vec4*>(parts.data() + block.place);
        const Lanes one = lanes_of(1);
        for (std::size_t k = 0; k < block.slices.size(); ++k) {
            const RowSlice& slice = block.slices[k];
            const CoefficientLanes& c = coefficients(block, k);
            const SliceView pairs(block, slice);
            const Lanes K = Real(0.5) * c.shear, outer = K + c.bulk;
            Lanes3 sum{};
            pairs.each([&](std::size_t, const Lanes3& r, const Lanes& w, const Index* other) {
                const Lanes3 g = w * (slice.inverse_moment * r);
                const Lanes left = at_least(one - dot(g, r), 0);
                const Lanes round = K * dot(g, g) + left * c.smooth * w, along = left * c.pair * w / dot(r, r);
                scatter(SymmetricLanes{outer * g.x * g.x + round + along * r.x * r.x, outer * g.y * g.y + round + along * r.y * r.y,
                                       outer * g.z * g.z + round + along * r.z * r.z, outer * g.x * g.y + along * r.x * r.y,
                                       outer * g.x * g.z + along * r.x * r.z, outer * g.y * g.z + along * r.y * r.z},
                        other, out);
                sum = sum + g;
            });
            const Lanes round = K * dot(sum, sum);
            SymmetricLanes self{outer * sum.x * sum.x + round, outer * sum.y * sum.y + round, outer * sum.z * sum.z + round,
                                outer * sum.x * sum.y,         outer * sum.x * sum.z,         outer * sum.y * sum.z};
            pairs.each([&](std::size_t, const Lanes3& r, const Lanes& w, const Index*) {
                const Lanes left = one - dot(sum, r), even = c.smooth * w * left, along = c.pair * w * left * left / dot(r, r);
                self.xx += even + along * r.x * r.x, self.yy += even + along * r.y * r.y, self.zz += even + along * r.z * r.z;
                self.xy += along * r.x * r.y, self.xz += along * r.x * r.z, self.yz += along * r.y * r.z;
            });
            scatter(self, slice.row, out);
        }
    });
    parallel_for(rows.size(), [&](Index i) {
        const Symmetric p = rows.gathered<Symmetric>(parts, i);
        Mat3& b = B[i];
        b << 1 + p.v[0], p.v[4], p.v[5], p.v[4], 1 + p.v[1], p.v[6], p.v[5], p.v[6], 1 + p.v[2];
        b += friction(i);
    });
}

}  // namespace whorl
