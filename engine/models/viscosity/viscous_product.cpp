// One product with the viscous operator: two passes over the pairs, each a gather of sixteen numbers a neighbour in one vector register.
#include "engine/core/parallel.h"
#include "engine/models/viscosity/full.h"

namespace whorl {
namespace {

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

// The compiler's own vectors: Eigen has no arithmetic between a register of sixteen and a broadcast of four.
using Lanes = Real __attribute__((vector_size(16 * sizeof(Real)), may_alias));
using Four = Real __attribute__((vector_size(4 * sizeof(Real)), may_alias));

// w four times over, doubled twice: in one step GCC 12 takes the way through memory.
#define WHORL_TWICE(w) __builtin_shufflevector(w, w, 0, 1, 2, 3, 4, 5, 6, 7)
#define WHORL_FOUR_TIMES(w) __builtin_shufflevector(WHORL_TWICE(w), WHORL_TWICE(w), 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15)

}  // namespace

/// sum_j w_ij,b (X_i - X_j)_ab with X = u (difference), or sum_j w_ij,b X_j,ab with X = Q.
template <bool difference>
void ViscousOperator::sum_row(Index i, Sixteen& sum) const {
    const Column<Sixteen>& X = difference ? u_ : Q_;
    const Lanes own = reinterpret_cast<const Lanes&>(X[at(i)]);
    const Index* other = pairs_->other.data();
    const Pair* pair = pair_.data();
    Lanes a{}, b{};  // two, to keep the multiply-adds apart
    const auto add = [&](std::size_t k, Lanes& to) __attribute__((always_inline)) {
        const Four w = reinterpret_cast<const Four&>(pair[k]);
        const Lanes& x = reinterpret_cast<const Lanes&>(X[at(other[k])]);
        if constexpr (difference) to += WHORL_FOUR_TIMES(w) * (own - x);
        else to += WHORL_FOUR_TIMES(w) * x;
    };
    std::size_t k = pairs_->first[at(i)];
    const std::size_t end = pairs_->first[at(i) + 1];
    for (; k + 1 < end; k += 2) add(k, a), add(k + 1, b);
    if (k < end) add(k, a);
    reinterpret_cast<Lanes&>(sum) = a + b;
}

void ViscousOperator::spread(Span<const Vec3> u, bool free_only) const {
    parallel_for(size(), [&](Index i) {
        const bool counts = !free_only || free_[at(i)];
        for (int a = 0; a < 3; ++a)
            for (int b = 0; b < 4; ++b) u_[at(i)].lane[4 * a + b] = counts ? u[at(i)][a] : 0;
        for (int b = 12; b < 16; ++b) u_[at(i)].lane[b] = 0;
    });
}

/// A = sum_j w u_ij r_ij^T, G = A M^+, Q = 2 K P D M^+ - 2 c G.
void ViscousOperator::stress(Span<const Vec3> u, bool with_walls) const {
    parallel_for(size(), [&](Index i) {
        Sixteen sum;
        sum_row<true>(i, sum);
        Mat3 A;
        Vec3 own;
        for (int a = 0; a < 3; ++a) {
            for (int b = 0; b < 3; ++b) A(a, b) = sum.lane[4 * a + b];
            own[a] = sum.lane[4 * a + 3];
        }
        if (!wall_.empty()) {
            const Wall& wall = wall_[at(i)];
            const Vec3 ui(u_[at(i)].lane[0], u_[at(i)].lane[4], u_[at(i)].lane[8]);
            A += ui * wall.wr.transpose();
            own += wall.spring * ui;
            if (with_walls) A -= wall.gradient, own -= wall.pull;
            if (friction_.acts()) own += rub_[at(i)] * (friction_.hold(i) * ui - (with_walls ? friction_.pull(i) : Vec3(Vec3::Zero())));
            if (bodies()) take_bodies(i, u, A, own);
        }
        const Mat3& M = M_[at(i)];
        const Real K = K_[at(i)], c = 2 * c_[at(i)];
        Mat3 Q;
        if (whole_[at(i)]) {
            const Mat3 G = A * M;
            Q = (K * (G + G.transpose()) - c * A) * M;
        } else {
            const Mat3& P = P_[at(i)];
            const Mat3 G = P * A * M;
            Q = (K * P * (G + G.transpose()) - c * A) * M;
        }
        Real* lane = Q_[at(i)].lane;
        for (int a = 0; a < 3; ++a) {
            for (int b = 0; b < 3; ++b) lane[4 * a + b] = Q(a, b);
            lane[4 * a + 3] = 0;
        }
        for (int b = 12; b < 16; ++b) lane[b] = 0;
        own_[at(i)] = own + Q * wr_[at(i)];
        if (bodies()) give_bodies(i, u, Vec3(u_[at(i)].lane[0], u_[at(i)].lane[4], u_[at(i)].lane[8]), Q);
    });
}

/// y = u + sum_j w (Q_i + Q_j) r_ij + 2 w (c_i + c_j) u_ij
void ViscousOperator::divergence(Span<const Vec3> u, Span<Vec3> y, bool free_only) const {
    parallel_for(size(), [&](Index i) {
        Sixteen sum;
        sum_row<false>(i, sum);
        const bool counts = !free_only || free_[at(i)];
        for (int a = 0; a < 3; ++a) {
            const Real force = own_[at(i)][a] + sum.lane[4 * a] + sum.lane[4 * a + 1] + sum.lane[4 * a + 2];
            y[at(i)][a] = counts ? u[at(i)][a] + force : 0;
        }
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
