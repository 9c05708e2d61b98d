// One product with the viscous operator, in two passes over the pairs. Each pass gathers sixteen numbers per neighbour in one vector
// register. The matrix products between the two passes also use such registers: lane 4 a + b contains the entry (a, b).
#if defined(__AVX512F__)
#include <immintrin.h>
#endif

#include "engine/core/parallel.h"
#include "engine/models/viscosity/flow_law.h"
#include "engine/models/viscosity/viscous_operator.h"

#pragma GCC diagnostic ignored "-Wpsabi"  // functions below that pass vectors by value are local to this file

namespace whorl {
namespace {

// Vector types of the compiler: Eigen has no arithmetic between a register of sixteen and a broadcast of four.
using SixteenLanes = Real __attribute__((vector_size(16 * sizeof(Real)), may_alias));
using Four = Real __attribute__((vector_size(4 * sizeof(Real)), may_alias));

template <class T>
const SixteenLanes& in_register(const T& sixteen) {
    return reinterpret_cast<const SixteenLanes&>(sixteen);
}

/// Repeats four numbers in each of the four rows.
SixteenLanes in_each_row(Four w) {
#if defined(__AVX512F__) && !defined(WHORL_DOUBLE)
    return reinterpret_cast<SixteenLanes>(_mm512_broadcast_f32x4(reinterpret_cast<__m128>(w)));
#else
    // Two shuffles, because GCC 12 compiles a single one with stores to memory.
    const auto twice = __builtin_shufflevector(w, w, 0, 1, 2, 3, 4, 5, 6, 7);
    return __builtin_shufflevector(twice, twice, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
#endif
}
SixteenLanes in_each_row(const Real* four) { return in_each_row(reinterpret_cast<const Four&>(*four)); }

#define WHORL_PICK(X, ...) __builtin_shufflevector(X, X, __VA_ARGS__)

SixteenLanes transposed(const SixteenLanes& X) { return WHORL_PICK(X, 0, 4, 8, 12, 1, 5, 9, 13, 2, 6, 10, 14, 3, 7, 11, 15); }

/// X times a matrix given as sixteen lanes in memory; uses the first three columns of X.
SixteenLanes times(const SixteenLanes& X, const Real* matrix) {
    return WHORL_PICK(X, 0, 0, 0, 0, 4, 4, 4, 4, 8, 8, 8, 8, 12, 12, 12, 12) * in_each_row(matrix) +
           WHORL_PICK(X, 1, 1, 1, 1, 5, 5, 5, 5, 9, 9, 9, 9, 13, 13, 13, 13) * in_each_row(matrix + 4) +
           WHORL_PICK(X, 2, 2, 2, 2, 6, 6, 6, 6, 10, 10, 10, 10, 14, 14, 14, 14) * in_each_row(matrix + 8);
}

/// P X, without column 3 of P.
SixteenLanes project(const SixteenLanes& P, const SixteenLanes& X) {
    return WHORL_PICK(P, 0, 0, 0, 0, 4, 4, 4, 4, 8, 8, 8, 8, 12, 12, 12, 12) *
               WHORL_PICK(X, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3) +
           WHORL_PICK(P, 1, 1, 1, 1, 5, 5, 5, 5, 9, 9, 9, 9, 13, 13, 13, 13) *
               WHORL_PICK(X, 4, 5, 6, 7, 4, 5, 6, 7, 4, 5, 6, 7, 4, 5, 6, 7) +
           WHORL_PICK(P, 2, 2, 2, 2, 6, 6, 6, 6, 10, 10, 10, 10, 14, 14, 14, 14) *
               WHORL_PICK(X, 8, 9, 10, 11, 8, 9, 10, 11, 8, 9, 10, 11, 8, 9, 10, 11);
}

/// Column 3 of X, zeros elsewhere.
SixteenLanes beside(const SixteenLanes& X) {
    return __builtin_shufflevector(SixteenLanes{}, X, 0, 1, 2, 19, 4, 5, 6, 23, 8, 9, 10, 27, 12, 13, 14, 31);
}

/// The sum of each row, in all its lanes.
SixteenLanes row_sums(const SixteenLanes& X) {
    const SixteenLanes pairs = X + WHORL_PICK(X, 1, 0, 3, 2, 5, 4, 7, 6, 9, 8, 11, 10, 13, 12, 15, 14);
    return pairs + WHORL_PICK(pairs, 2, 3, 0, 1, 6, 7, 4, 5, 10, 11, 8, 9, 14, 15, 12, 13);
}

/// The last four lanes.
Four last_row(const SixteenLanes& X) { return __builtin_shufflevector(X, X, 12, 13, 14, 15); }

/// The shortest image of r in a periodic domain. The fourth component stays.
Four wrapped(Four r, const Vec3& period, const Vec3& inverse) {
    for (int a = 0; a < 3; ++a) r[a] -= period[a] * std::nearbyint(r[a] * inverse[a]);
    return r;
}

/// sum_j (w r_ij, 2 w (c_i + c_j))_b f(X_j)_ab over the neighbours j of i. @param X with positions and -2 c in the last row
template <bool periodic, class Sixteen, class F>
SixteenLanes sum_row(const FluidPairs& pairs, const Real* weight, const Sixteen* X, Index i, const F& f) {
    const Index* other = pairs.other.data();
    const Four own = last_row(in_register(X[i])) * Four{1, 1, 1, -1};
    const Vec3 period = pairs.period, inverse = (period.array() > 0).select(1 / period.array(), 0);
    const auto term = [&](std::size_t k) {
        const SixteenLanes& there = in_register(X[other[k]]);
        Four r = own - last_row(there);
        if constexpr (periodic) r = wrapped(r, period, inverse);
        return in_each_row(r * weight[k]) * f(there);
    };
    SixteenLanes a{}, b{};  // two independent sums, so that multiply-adds overlap
    std::size_t k = pairs.first[i];
    const std::size_t end = pairs.first[i + 1];
    for (; k + 1 < end; k += 2) a += term(k), b += term(k + 1);
    if (k < end) a += term(k);
    return a + b;
}
template <class Sixteen, class F>
SixteenLanes sum_row(const FluidPairs& pairs, const Column<Real>& weight, const Column<Sixteen>& X, Index i, const F& f) {
    return pairs.period == Vec3::Zero() ? sum_row<false>(pairs, weight.data(), X.data(), i, f)
                                        : sum_row<true>(pairs, weight.data(), X.data(), i, f);
}

}  // namespace

void ViscousOperator::spread(Span<const Vec3> u, bool free_only) const {
    parallel_for(size(), [&](Index i) {
        const bool counts = !free_only || free_[i];
        alignas(4 * sizeof(Real)) Real v[4] = {counts ? u[i][0] : 0, counts ? u[i][1] : 0, counts ? u[i][2] : 0, 0};
        const SixteenLanes rows = in_each_row(v);
        reinterpret_cast<SixteenLanes&>(u_[i]) = WHORL_PICK(rows, 0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3);
        std::copy_n(pairs_->x_own[i].data(), 3, u_[i].lane + 12);
        u_[i].lane[15] = -2 * c_[i];
    });
}

/// A = sum_j w u_ij r_ij^T, G = A M^+, S = 2 P (D - T). Symbols as in viscous_operator.h. T, the walls' own velocities and the load of
/// their friction are included only if with_known. The fourth column of A is the force of the penalty's springs.
/// @param f called with (i, u_i in all columns, A, S) for each particle
template <class F>
void ViscousOperator::each_strain(Span<const Vec3> u, bool with_known, const F& f) const {
    const bool walls_push_back = friction_.acts() || bodies();
    parallel_for(size(), [&](Index i) {
        const SixteenLanes own = in_register(u_[i]);
        SixteenLanes A = sum_row(*pairs_, weight_, u_, i, [&](const SixteenLanes& there) { return own - there; });
        if (!wall_.empty()) {
            const Vec3 ui(own[0], own[4], own[8]);
            const Wall& wall = wall_[i];
            A += in_each_row(wall.near.wr.data()) * own;
            if (with_known) A -= in_register(wall.moving);
            if (walls_push_back) {
                Sixteen sum;
                reinterpret_cast<SixteenLanes&>(sum) = A;
                Mat3 gradient = sum.matrix();
                Vec3 pull = sum.beside();
                if (friction_.acts())
                    pull += dt_nu_[i] * (friction_.coefficient(i) * ui - (with_known ? friction_.load(i) : Vec3(Vec3::Zero())));
                if (bodies()) subtract_body_velocities(i, u, gradient, pull);
                sum.set(gradient, pull);
                A = in_register(sum);
            }
        }
        SixteenLanes G = times(A, M_[i].lane);
        if (!whole_[i]) G = project(in_register(P_[i]), G);
        G += transposed(G);
        if (!whole_[i]) G = project(in_register(P_[i]), G);
        if (with_known && !curvature_.empty()) G -= in_register(curvature_[i]);
        f(i, own, A, G);
    });
}

/// Q = K S M^+ - 2 c G
void ViscousOperator::stress(Span<const Vec3> u, bool with_known) const {
    each_strain(u, with_known, [&](Index i, const SixteenLanes& own, const SixteenLanes& A, const SixteenLanes& S) {
        const Real K = K_[i], c = 2 * c_[i];
        const Real* M = M_[i].lane;
        const SixteenLanes Q = whole_[i] == 2 ? times(K * S, M) - times(c * A, P_[i].lane) : times(K * S - c * A, M);
        reinterpret_cast<SixteenLanes&>(Q_[i]) = __builtin_shufflevector(Q, own, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 28, 29, 30, 31);
        reinterpret_cast<SixteenLanes&>(own_[i]) = Q * in_each_row(wr_[i].wr.data()) + beside(A + own);
        if (bodies()) set_body_forces(i, u, Vec3(own[0], own[4], own[8]), Q_[i].matrix());
    });
}

void ViscousOperator::shear_rates(Span<const Vec3> u, Span<Real> gamma) const {
    spread(u, false);
    each_strain(u, true, [&](Index i, const SixteenLanes&, const SixteenLanes&, const SixteenLanes& S) {
        Sixteen twice;
        reinterpret_cast<SixteenLanes&>(twice) = S;
        gamma[i] = shear_rate(twice.matrix() / 2, dimensions_);
    });
}

/// y = u + sum_j w (Q_i + Q_j) r_ij + 2 w (c_i + c_j) u_ij
void ViscousOperator::divergence(Span<const Vec3> u, Span<Vec3> y, bool free_only) const {
    parallel_for(size(), [&](Index i) {
        const SixteenLanes sums =
            row_sums(in_register(own_[i]) + sum_row(*pairs_, weight_, Q_, i, [](const SixteenLanes& there) { return there; }));
        y[i] = !free_only || free_[i] ? Vec3(sums[0], sums[4], sums[8]) : Vec3(Vec3::Zero());
    });
    if (bodies()) sum_bodies(u, y);
}

void ViscousOperator::multiply(Span<const Vec3> u, Span<Vec3> y) const {
    spread(u, true);
    stress(u, false);
    divergence(u, y, true);
}

void ViscousOperator::force(Span<const Vec3> u, Span<Vec3> y) const {
    spread(u, false);
    stress(u, true);
    divergence(u, y, false);
}

}  // namespace whorl
