#include "engine/models/viscosity/coupled/strain_form.h"

#include "engine/core/parallel.h"

namespace whorl {
namespace {

/// One pair per row of a slice, stored in the first pass for the second.
struct KeptPair {
    Lanes3 r, v;         ///< v = u_j - u_i
    Lanes w, stiffness;  ///< stiffness = w/r^2
};

/// Buffer of the calling thread, for any slice.
KeptPair* room_for_pairs(const CoupledRows& rows) {
    thread_local Column<KeptPair> room;
    if (room.size() < static_cast<std::size_t>(rows.widest_slice)) room.resize(static_cast<std::size_t>(rows.widest_slice));
    return room.data();
}

/// Matrix E of a rigid motion at the arm a: E (v, w) = v + w x a.
Eigen::Matrix<double, 3, 6> rigid_motion(const Vec3d& a) {
    Eigen::Matrix<double, 3, 6> E;
    E << 1, 0, 0, 0, a[2], -a[1],  //
        0, 1, 0, -a[2], 0, a[0],   //
        0, 0, 1, a[1], -a[0], 0;
    return E;
}

/// Sums over a row's pairs.
struct PairSums {
    Lanes33 A{};             ///< sum w (u_j - u_i) r^T
    SymmetricLanes along{};  ///< sum w/r^2 ((u_j - u_i).r) r r^T
};

PairSums sum_pairs(const SliceView<true>& pairs, KeptPair* kept) {
    PairSums sum;
    pairs.each([&](std::size_t k, const PairLanes& p) {
        const Lanes3 &r = p.r, &v = p.v;
        add_outer(v, p.w * r, sum.A);
        const Lanes xx = r.x * r.x, yy = r.y * r.y, zz = r.z * r.z;
        const Lanes stiffness = p.w / p.r2;
        kept[k] = {r, v, p.w, stiffness};
        const Lanes t = stiffness * dot(v, r), tx = t * r.x, ty = t * r.y;
        SymmetricLanes& B = sum.along;
        B.xx += t * xx, B.yy += t * yy, B.zz += t * zz, B.xy += tx * r.y, B.xz += tx * r.z, B.yz += ty * r.z;
    });
    return sum;
}

/// Returns to the particles the part of the forces on walls that the fluid does not transmit because it slides.
/// @param out forces on the block's entries
void return_sliding(const RowBlock& block, Vec4* out) {
    for (std::size_t k = 0; k < block.walls.size(); ++k) {
        const WallPoint& wall = block.walls[k];
        if (!wall.slides()) continue;
        Vec4& on_wall = out[block.touched.size() + k];
        const Vec4 back = with_spare(wall.slipping(Vec3(on_wall.v[0], on_wall.v[1], on_wall.v[2])));
        quad(out[wall.row]) += quad(back);
        quad(on_wall) -= quad(back);
    }
}

}  // namespace

void StrainForm::set(const CoupledRows& rows, Span<const Real> viscosity, Real dt, Real density, Real spacing, const CoupledOptions& o) {
    rows_ = &rows;
    friction_ = {};
    bodies_ = nullptr;
    spacing_ = spacing;
    forces_.resize(rows.entries());
    by_slice_.resize(rows.slices);
    parallel_for(static_cast<Index>(rows.blocks.size()), [&](Index b) {
        const RowBlock& block = rows.blocks[b];
        for (std::size_t k = 0; k < block.slices.size(); ++k)
            for (Index lane = 0; lane < lane_count; ++lane) {
                const Index i = block.begin + block.slices[k].row[lane];
                const Neighbourhood& n = rows.neighbourhood[i];
                const double of_mu = n.volume * dt / (double(density) * spacing * spacing);
                const double base = n.spread > 0 ? 2 * rows.dimensions() / n.spread : 0;
                double K = of_mu * double(viscosity[i]), penalised = K, pressed = K, bulk = o.bulk;
                if (!soft_.empty()) {
                    Real softest = soft_[i], thinnest = viscosity[i];
                    block.each_pair(i - block.begin, [&](RowBlock::LocalIndex at) {
                        softest = std::min(softest, soft_[block.touched[at]]);
                        thinnest = std::min(thinnest, viscosity[block.touched[at]]);
                    });
                    penalised *= std::min(1.0, static_cast<double>(softest / viscosity[i]));
                    K = std::min(K, o.steepest_jump * of_mu * thinnest);
                    pressed = std::min(K, o.rigid_bulk);
                    if (K < o.least_bulk) bulk *= o.least_bulk / K;
                }
                StrainCoefficients c;
                c.shear = static_cast<Real>(2 * K);
                c.bulk = static_cast<Real>(2 * pressed * bulk / (2 + n.unresolved * bulk));
                c.smooth = static_cast<Real>(base * (penalised * o.smoothing));
                c.pair = static_cast<Real>(base * (penalised * o.pair_smoothing));
                by_slice_[block.first_slice + k].set(lane, c);
            }
    });
}

void StrainForm::find_forces(Span<const Vec3> u, bool moving, bool at_walls) const {
    const CoupledRows& rows = *rows_;
    parallel_blocks(rows.size(), CoupledRows::block_size, [&](Index begin, Index) {
        const RowBlock& block = rows.blocks[begin / CoupledRows::block_size];
        if (at_walls && block.walls.empty()) return;
        KeptPair* const kept = room_for_pairs(rows);
        const Vec4* at = rows.positions(block, u, moving);
        Vec4* out = forces_.data() + block.place;
        std::fill(out, out + block.entries(), Vec4{{0, 0, 0, 0}});
        for (std::size_t k = 0; k < block.slices.size(); ++k) {
            const RowSlice& slice = block.slices[k];
            if (at_walls && slice.walls == 0) continue;
            const CoefficientLanes& c = coefficients(block, k);
            const PairSums sum = sum_pairs(rows.pairs_with(block, slice, at), kept);
            const Lanes33 G = sum.A * slice.inverse_moment;
            const SymmetricLanes D = symmetric(G);
            const auto resolved_of = [&](const Lanes33& m) { return resolved_part(block, slice, m); };
            const Lanes33 Q = row_force(G, sum.along, c, slice.inverse_moment, slice.fourth, slice.resolved, resolved_of);
            // Force on j: Q w r + 2 c w (u_j - u_i) + t r,  t = 2 c' w/r^2 ((u_j - u_i).r - r.D r)
            Lanes3 total{};
            for (std::size_t e = 0; e < static_cast<std::size_t>(slice.width); ++e) {
                const KeptPair& p = kept[e];
                const Lanes t = c.pair * p.stiffness * (dot(p.v, p.r) - dot(p.r, D * p.r));
                const Lanes3 f = p.w * (Q * p.r + c.smooth * p.v) + t * p.r;
                total = total + f;
                scatter(f, block.other.data() + slice.begin + e * lane_count, out);
            }
            scatter(Lanes3{-total.x, -total.y, -total.z}, slice.row, out);
        }
        if (rows.any_slip) return_sliding(block, out);
    });
}

void StrainForm::apply(Span<const Vec3> u, Span<Vec3> y, bool moving) const {
    find_forces(u, moving);
    parallel_for(rows_->size(), [&](Index i) { y[i] = applied(u, i); });
    if (bodies_ != nullptr) apply_to_bodies(u, y);
}

void StrainForm::set_bodies(const ViscousBodies& bodies) {
    bodies_ = bodies.body.empty() ? nullptr : &bodies;
    body_points_.clear();
    if (bodies_ == nullptr) return;
    for (const RowBlock& block : rows_->blocks)
        for (std::size_t k = 0; k < block.walls.size(); ++k)
            if (const WallPoint& wall = block.walls[k]; wall.body >= 0)
                body_points_.push_back({block.place + block.touched.size() + k, wall.body, wall.arm});
}

void StrainForm::add_wall_forces(Span<Vec3> y) const {
    std::vector<Wrench> all(bodies_->body.size());
    for (const BodyPoint& point : body_points_) {
        const Vec4& f = forces_[point.place];
        all[point.body] += Wrench::at(point.arm.cast<double>(), Vec3d(f.v[0], f.v[1], f.v[2]));
    }
    const Span<Vec3> of_bodies = y.subspan(static_cast<std::size_t>(rows_->size()));
    for (std::size_t b = 0; b < all.size(); ++b)
        of_bodies[2 * b] += all[b].force.cast<Real>(), of_bodies[2 * b + 1] += all[b].torque.cast<Real>();
}

double StrainForm::apply_to_bodies(Span<const Vec3> u, Span<Vec3> y) const {
    const auto n = static_cast<std::size_t>(rows_->size());
    bodies_->weigh(u.subspan(n), y.subspan(n));
    add_wall_forces(y);
    double product = 0;
    for (std::size_t k = n; k < u.size(); ++k) product += dot_entry(u[k], y[k]);
    return product;
}

/// P m of each lane.
Lanes33 StrainForm::resolved_part(const RowBlock& block, const RowSlice& slice, const Lanes33& m) const {
    Lanes33 product;
    for (Index lane = 0; lane < lane_count; ++lane)
        set_lane(product, lane, rows_->resolved(block.begin + slice.row[lane]) * lane_of(m, lane));
    return product;
}

void StrainForm::find_stress(Span<const Real> q, Span<const Mat3> T, bool at_walls) const {
    const CoupledRows& rows = *rows_;
    parallel_blocks(rows.size(), CoupledRows::block_size, [&](Index begin, Index) {
        const RowBlock& block = rows.blocks[begin / CoupledRows::block_size];
        if (at_walls && block.walls.empty()) return;
        Vec4* out = forces_.data() + block.place;
        std::fill(out, out + block.entries(), Vec4{{0, 0, 0, 0}});
        const Vec4* at = rows.positions(block);
        for (std::size_t k = 0; k < block.slices.size(); ++k) {
            const RowSlice& slice = block.slices[k];
            if (at_walls && slice.walls == 0) continue;
            const CoefficientLanes& c = coefficients(block, k);
            Lanes33 stress;
            for (Index lane = 0; lane < lane_count; ++lane) {
                const auto i = static_cast<std::size_t>(block.begin + slice.row[lane]);
                Mat3 S = q[i] * Mat3::Identity();
                if (!T.empty()) S += c.shear[lane] * spacing_ * T[i];
                set_lane(stress, lane, S);
            }
            if (!slice.resolved) stress = resolved_part(block, slice, stress);
            const Lanes33 Q = stress * slice.inverse_moment;
            Lanes3 total{};
            rows.pairs_of(block, slice, at).each([&](std::size_t, const PairLanes& p) {
                const Lanes3 f = p.w * (Q * p.r);
                total = total + f;
                scatter(f, p.other, out);
            });
            scatter(Lanes3{-total.x, -total.y, -total.z}, slice.row, out);
        }
        if (rows.any_slip) return_sliding(block, out);
    });
}

void StrainForm::add_stress(Span<const Real> q, Span<const Mat3> T, Span<Vec3> y) const {
    find_stress(q, T, false);
    parallel_for(rows_->size(), [&](Index i) {
        const Vec4 f = rows_->gathered(forces_, i)[0];
        y[i] += Vec3(f.v[0], f.v[1], f.v[2]);
    });
    if (bodies_ != nullptr && y.size() > static_cast<std::size_t>(rows_->size())) add_wall_forces(y);
}

void velocity_gradients(const CoupledRows& rows, Real spacing, Span<const Vec3> u, Span<Mat3> G) {
    parallel_blocks(rows.size(), CoupledRows::block_size, [&](Index begin, Index) {
        const RowBlock& block = rows.blocks[begin / CoupledRows::block_size];
        const Vec4* at = rows.positions(block, u, true);
        const Lanes per_metre = lanes_of(1 / spacing);
        for (const RowSlice& slice : block.slices) {
            Lanes33 A{};
            rows.pairs_with(block, slice, at).each([&](std::size_t, const PairLanes& p) { add_outer(p.v, p.w * p.r, A); });
            for (auto& row : A.m)
                for (Lanes& v : row) v *= per_metre;
            const Lanes33 gradient = A * slice.inverse_moment;
            for (Index lane = 0; lane < slice.rows; ++lane) G[block.begin + slice.row[lane]] = lane_of(gradient, lane);
        }
    });
}

Real StrainForm::divergence(Index i, const Mat3& G) const {
    const Neighbourhood& n = rows_->neighbourhood[i];
    return n.unresolved == 0 ? G.trace() : (rows_->resolved(i) * G).trace();
}

// With g = M+ w r, row i adds to the block of j the strain's K (1 + Lambda) g g^T + K |g|^2 and the penalties' 2 w (1 - g.r)(c + c' r r^T /
// r^2), in which the last r r^T approximates a fourth moment. To the block of i the row adds the strain's terms with g replaced by -h, h =
// sum g, and the sum over its pairs of 2 w ((1 - h.r) c + (1 - h.r)^2 c' r r^T / r^2).
void StrainForm::diagonal(Span<Mat3> B, std::vector<SymmetricBlocks::Block>* of_bodies) const {
    const CoupledRows& rows = *rows_;
    Column<Vec4> parts(2 * rows.entries(), Vec4{});  // xx yy zz, xy xz yz
    parallel_blocks(rows.size(), CoupledRows::block_size, [&](Index begin, Index) {
        const RowBlock& block = rows.blocks[begin / CoupledRows::block_size];
        KeptPair* const kept = room_for_pairs(rows);
        Vec4* out = parts.data() + 2 * block.place;
        const Vec4* at = rows.positions(block);
        const Lanes one = lanes_of(1);
        for (std::size_t k = 0; k < block.slices.size(); ++k) {
            const RowSlice& slice = block.slices[k];
            const CoefficientLanes& c = coefficients(block, k);
            const Lanes K = Real(0.5) * c.shear, outer = K + c.bulk;
            Lanes3 sum{};
            rows.pairs_of(block, slice, at).each([&](std::size_t e, const PairLanes& p) {
                const Lanes3& r = p.r;
                const Lanes& w = p.w;
                const Lanes3 g = w * (slice.inverse_moment * r);
                const Lanes left = at_least(one - dot(g, r), 0);
                const Lanes round = K * dot(g, g) + left * c.smooth * w, stiffness = w / p.r2, along = left * c.pair * stiffness;
                kept[e] = {r, {}, w, stiffness};
                scatter(SymmetricLanes{outer * g.x * g.x + round + along * r.x * r.x, outer * g.y * g.y + round + along * r.y * r.y,
                                       outer * g.z * g.z + round + along * r.z * r.z, outer * g.x * g.y + along * r.x * r.y,
                                       outer * g.x * g.z + along * r.x * r.z, outer * g.y * g.z + along * r.y * r.z},
                        p.other, out);
                sum = sum + g;
            });
            const Lanes round = K * dot(sum, sum);
            SymmetricLanes self{outer * sum.x * sum.x + round, outer * sum.y * sum.y + round, outer * sum.z * sum.z + round,
                                outer * sum.x * sum.y,         outer * sum.x * sum.z,         outer * sum.y * sum.z};
            for (std::size_t e = 0; e < static_cast<std::size_t>(slice.width); ++e) {
                const KeptPair& p = kept[e];
                const Lanes3& r = p.r;
                const Lanes left = one - dot(sum, r), even = c.smooth * p.w * left, along = c.pair * p.stiffness * left * left;
                self.xx += even + along * r.x * r.x, self.yy += even + along * r.y * r.y, self.zz += even + along * r.z * r.z;
                self.xy += along * r.x * r.y, self.xz += along * r.x * r.z, self.yz += along * r.y * r.z;
            }
            scatter(self, slice.row, out);
        }
    });
    parallel_for(rows.size(), [&](Index i) {
        const auto [even, mixed] = rows.gathered<2>(parts, i);
        const Real *e = even.v, *m = mixed.v;
        Mat3& b = B[i];
        b << 1 + e[0], m[0], m[1], m[0], 1 + e[1], m[2], m[1], m[2], 1 + e[2];
        b += friction(i);
    });
    if (of_bodies == nullptr) return;
    of_bodies->clear();
    if (bodies_ == nullptr) return;
    for (const auto& body : bodies_->body) of_bodies->push_back(body.inertia());
    for (const BodyPoint& point : body_points_) {
        const Vec4 &even = parts[2 * point.place], &mixed = parts[2 * point.place + 1];
        Mat3d W;
        W << even.v[0], mixed.v[0], mixed.v[1], mixed.v[0], even.v[1], mixed.v[2], mixed.v[1], mixed.v[2], even.v[2];
        const Eigen::Matrix<double, 3, 6> E = rigid_motion(point.arm.cast<double>());
        (*of_bodies)[static_cast<std::size_t>(point.body)] += E.transpose() * W * E;
    }
}

}  // namespace whorl
