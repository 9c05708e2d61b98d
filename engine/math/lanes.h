#pragma once
/// SIMD vectors of Reals, one number per lane, with gather from and scatter to points in memory.
#ifdef __AVX512VL__
#include <immintrin.h>
#endif

#include <cmath>

#include "engine/core/types.h"

namespace whorl {

#pragma GCC diagnostic ignored "-Wpsabi"  // all functions on lanes are inline: a call would put every register into memory

#if defined(__AVX512F__)
inline constexpr Index lane_count = 64 / sizeof(Real);
#elif defined(__AVX__)
inline constexpr Index lane_count = 32 / sizeof(Real);
#else
inline constexpr Index lane_count = 4;
#endif

using Lanes = Real __attribute__((vector_size(lane_count * sizeof(Real))));
static_assert(lane_count == 4 || lane_count == 8 || lane_count == 16);

/// Four numbers that are aligned together: a vector and a spare number.
struct alignas(4 * sizeof(Real)) Vec4 {
    Real v[4];
};

using Quad = Real __attribute__((vector_size(4 * sizeof(Real))));
inline const Quad& quad(const Vec4& from) { return *reinterpret_cast<const Quad*>(from.v); }
inline Quad& quad(Vec4& to) { return *reinterpret_cast<Quad*>(to.v); }

/// v, with 0 as the spare number.
inline Vec4 with_spare(const Vec3& v) {
#if defined(__AVX512VL__) && !defined(WHORL_DOUBLE)
    Vec4 four;
    _mm_store_ps(four.v, _mm_maskz_loadu_ps(0b0111, v.data()));
    return four;
#else
    return {{v[0], v[1], v[2], 0}};
#endif
}

/// A vector in each lane.
struct Lanes3 {
    Lanes x{}, y{}, z{};
};

/// A symmetric matrix in each lane.
struct SymmetricLanes {
    Lanes xx{}, yy{}, zz{}, xy{}, xz{}, yz{};
};

/// A matrix in each lane: m[row][column].
struct Lanes33 {
    Lanes m[3][3];
};

/// v in every lane.
inline Lanes lanes_of(Real v) { return v - Lanes{}; }
inline SymmetricLanes lanes_of(const Mat3& m) {
    return {lanes_of(m(0, 0)), lanes_of(m(1, 1)), lanes_of(m(2, 2)), lanes_of(m(0, 1)), lanes_of(m(0, 2)), lanes_of(m(1, 2))};
}
inline Lanes at_least(Lanes v, Real least) { return v > least ? v : lanes_of(least); }
inline Lanes at_most(Lanes v, Real most) { return v < most ? v : lanes_of(most); }

inline bool any_above(Lanes v, Real limit) {
    bool any = false;
    for (Index lane = 0; lane < lane_count; ++lane) any |= v[lane] > limit;
    return any;
}
inline Lanes square_root(Lanes v) {
    for (Index lane = 0; lane < lane_count; ++lane) v[lane] = std::sqrt(v[lane]);
    return v;
}
inline Lanes rounded(Lanes v) {
    for (Index lane = 0; lane < lane_count; ++lane) v[lane] = std::nearbyint(v[lane]);
    return v;
}
inline void set_lane(SymmetricLanes& to, Index lane, const Mat3& m) {
    to.xx[lane] = m(0, 0), to.yy[lane] = m(1, 1), to.zz[lane] = m(2, 2), to.xy[lane] = m(0, 1), to.xz[lane] = m(0, 2),
    to.yz[lane] = m(1, 2);
}

namespace detail {

// L in this namespace is always Lanes. It is a template parameter so that clang skips the branches for other lane counts.

/// Index in the pair (p, q) of Lanes of element k of group `four` (four elements each): k = 0 to 3 are in p, k = 4 to 7 in q.
constexpr int in_four(int k, int four) { return k < 4 ? 4 * four + k : lane_count + 4 * four + k - 4; }

/// Each group of four in the result has the elements a, b, c, d of the groups of p (0 to 3) and q (4 to 7) at the same position.
template <int a, int b, int c, int d, class L>
[[gnu::always_inline]] inline L fours(L p, L q) {
    if constexpr (lane_count == 16)
        return __builtin_shufflevector(p, q, in_four(a, 0), in_four(b, 0), in_four(c, 0), in_four(d, 0), in_four(a, 1), in_four(b, 1),
                                       in_four(c, 1), in_four(d, 1), in_four(a, 2), in_four(b, 2), in_four(c, 2), in_four(d, 2),
                                       in_four(a, 3), in_four(b, 3), in_four(c, 3), in_four(d, 3));
    else if constexpr (lane_count == 8)
        return __builtin_shufflevector(p, q, in_four(a, 0), in_four(b, 0), in_four(c, 0), in_four(d, 0), in_four(a, 1), in_four(b, 1),
                                       in_four(c, 1), in_four(d, 1));
    else return __builtin_shufflevector(p, q, in_four(a, 0), in_four(b, 0), in_four(c, 0), in_four(d, 0));
}

/// The Vec4 at the indices stride place[0], stride place[4], stride place[8] ... of `from`, in one register.
template <int stride, class Place>
[[gnu::always_inline]] inline Lanes every_fourth(const Vec4* from, const Place* place) {
    if constexpr (lane_count == 16) {
        const auto low = __builtin_shufflevector(quad(from[stride * place[0]]), quad(from[stride * place[4]]), 0, 1, 2, 3, 4, 5, 6, 7);
        const auto high = __builtin_shufflevector(quad(from[stride * place[8]]), quad(from[stride * place[12]]), 0, 1, 2, 3, 4, 5, 6, 7);
        return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    } else if constexpr (lane_count == 8) {
        return __builtin_shufflevector(quad(from[stride * place[0]]), quad(from[stride * place[4]]), 0, 1, 2, 3, 4, 5, 6, 7);
    } else {
        return quad(from[stride * place[0]]);
    }
}

using Eight = Real __attribute__((vector_size(8 * sizeof(Real))));

/// The two Vec4 from index 2 place[0] on; with sixteen lanes also the two from index 2 place[4] on.
template <class Place>
[[gnu::always_inline]] inline Lanes two_pieces(const Vec4* from, const Place* place) {
    const auto eight = [&](Index k) { return *reinterpret_cast<const Eight*>(from + 2 * static_cast<std::size_t>(place[k])); };
    if constexpr (lane_count == 16)
        return __builtin_shufflevector(eight(0), eight(4), 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    else return eight(0);
}

/// Every second group of four elements of a, then of b. It begins with the first group if `first` is 0, with the second if it is 1.
template <int first, class L>
[[gnu::always_inline]] inline L every_second_four(L a, L b) {
    constexpr int k = 4 * first;
    if constexpr (lane_count == 16)
        return __builtin_shufflevector(a, b, k, k + 1, k + 2, k + 3, k + 8, k + 9, k + 10, k + 11, k + 16, k + 17, k + 18, k + 19, k + 24,
                                       k + 25, k + 26, k + 27);
    else return __builtin_shufflevector(a, b, k, k + 1, k + 2, k + 3, k + 8, k + 9, k + 10, k + 11);
}

template <int four>
Quad four_of(Lanes v) {
    return __builtin_shufflevector(v, v, 4 * four, 4 * four + 1, 4 * four + 2, 4 * four + 3);
}

/// Adds the groups of four elements in v to the Vec4 at the indices stride place[0], stride place[4], stride place[8] ... of `to`.
template <int stride, class Place>
[[gnu::always_inline]] inline void add_to_every_fourth(Lanes v, const Place* place, Vec4* to) {
    quad(to[stride * place[0]]) += four_of<0>(v);
    if constexpr (lane_count > 4) quad(to[stride * place[4]]) += four_of<1>(v);
    if constexpr (lane_count > 8) {
        quad(to[stride * place[8]]) += four_of<2>(v);
        quad(to[stride * place[12]]) += four_of<3>(v);
    }
}

}  // namespace detail

/// The vectors from[stride place[lane]]. @param fourth (out) spare numbers of these vectors, unless null
template <int stride = 1, class Place>
[[gnu::always_inline]] inline Lanes3 gather(const Vec4* from, const Place* place, Lanes* fourth = nullptr) {
    using detail::fours;
    const Lanes a = detail::every_fourth<stride>(from, place), b = detail::every_fourth<stride>(from, place + 1);
    const Lanes c = detail::every_fourth<stride>(from, place + 2), d = detail::every_fourth<stride>(from, place + 3);
    const Lanes xy0 = fours<0, 4, 1, 5>(a, b), xy1 = fours<0, 4, 1, 5>(c, d);
    const Lanes zw0 = fours<2, 6, 3, 7>(a, b), zw1 = fours<2, 6, 3, 7>(c, d);
    if (fourth != nullptr) *fourth = fours<2, 3, 6, 7>(zw0, zw1);
    return {fours<0, 1, 4, 5>(xy0, xy1), fours<2, 3, 6, 7>(xy0, xy1), fours<0, 1, 4, 5>(zw0, zw1)};
}

struct TwoLanes3 {
    Lanes3 first, second;
};

/// The vectors from[2 place[lane]] and from[2 place[lane] + 1]. This is cheaper than two calls of gather().
template <class Place>
[[gnu::always_inline]] inline TwoLanes3 gather_two(const Vec4* from, const Place* place) {
    using detail::fours;
    if constexpr (lane_count == 4) {
        return {gather<2>(from, place), gather<2>(from + 1, place)};
    } else {
        // Gathers half of the lanes. In the result, groups of four components of first vectors and of second vectors alternate.
        const auto half = [&](const Place* p) {
            const Lanes a = detail::two_pieces(from, p), b = detail::two_pieces(from, p + 1);
            const Lanes c = detail::two_pieces(from, p + 2), d = detail::two_pieces(from, p + 3);
            const Lanes xy0 = fours<0, 4, 1, 5>(a, b), xy1 = fours<0, 4, 1, 5>(c, d);
            const Lanes zw0 = fours<2, 6, 3, 7>(a, b), zw1 = fours<2, 6, 3, 7>(c, d);
            return Lanes3{fours<0, 1, 4, 5>(xy0, xy1), fours<2, 3, 6, 7>(xy0, xy1), fours<0, 1, 4, 5>(zw0, zw1)};
        };
        const Lanes3 low = half(place), high = half(place + lane_count / 2);
        using detail::every_second_four;
        return {{every_second_four<0>(low.x, high.x), every_second_four<0>(low.y, high.y), every_second_four<0>(low.z, high.z)},
                {every_second_four<1>(low.x, high.x), every_second_four<1>(low.y, high.y), every_second_four<1>(low.z, high.z)}};
    }
}

/// Adds the vector of each lane to to[stride place[lane]]. The order is fixed, so entries of `place` may repeat.
template <int stride = 1, class Place>
[[gnu::always_inline]] inline void scatter(const Lanes3& v, const Place* place, Vec4* to) {
    using detail::fours;
    const Lanes none{};
    const Lanes xy0 = fours<0, 4, 1, 5>(v.x, v.y), xy1 = fours<2, 6, 3, 7>(v.x, v.y);
    const Lanes z0 = fours<0, 4, 1, 5>(v.z, none), z1 = fours<2, 6, 3, 7>(v.z, none);
    detail::add_to_every_fourth<stride>(fours<0, 1, 4, 5>(xy0, z0), place, to);
    detail::add_to_every_fourth<stride>(fours<2, 3, 6, 7>(xy0, z0), place + 1, to);
    detail::add_to_every_fourth<stride>(fours<0, 1, 4, 5>(xy1, z1), place + 2, to);
    detail::add_to_every_fourth<stride>(fours<2, 3, 6, 7>(xy1, z1), place + 3, to);
}

/// Adds the symmetric matrix of each lane to the two Vec4 from index 2 place[lane] on: (xx, yy, zz) and (xy, xz, yz).
template <class Place>
[[gnu::always_inline]] inline void scatter(const SymmetricLanes& m, const Place* place, Vec4* to) {
    scatter<2>(Lanes3{m.xx, m.yy, m.zz}, place, to);
    scatter<2>(Lanes3{m.xy, m.xz, m.yz}, place, to + 1);
}

inline Lanes dot(const Lanes3& a, const Lanes3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Lanes3 operator+(const Lanes3& a, const Lanes3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Lanes3 operator-(const Lanes3& a, const Lanes3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Lanes3 operator*(const Lanes& a, const Lanes3& b) { return {a * b.x, a * b.y, a * b.z}; }
inline Lanes3 operator*(const SymmetricLanes& m, const Lanes3& v) {
    return {m.xx * v.x + m.xy * v.y + m.xz * v.z, m.xy * v.x + m.yy * v.y + m.yz * v.z, m.xz * v.x + m.yz * v.y + m.zz * v.z};
}
inline Lanes3 operator*(const Lanes33& a, const Lanes3& v) {
    const auto row = [&](int k) { return a.m[k][0] * v.x + a.m[k][1] * v.y + a.m[k][2] * v.z; };
    return {row(0), row(1), row(2)};
}
inline Lanes33 operator*(const Lanes33& a, const SymmetricLanes& b) {
    Lanes33 p;
    for (int k = 0; k < 3; ++k) {
        const Lanes *from = a.m[k], x = from[0], y = from[1], z = from[2];
        p.m[k][0] = x * b.xx + y * b.xy + z * b.xz;
        p.m[k][1] = x * b.xy + y * b.yy + z * b.yz;
        p.m[k][2] = x * b.xz + y * b.yz + z * b.zz;
    }
    return p;
}
inline Lanes33 operator*(const SymmetricLanes& a, const Lanes33& b) {
    Lanes33 p;
    for (int k = 0; k < 3; ++k) {
        const Lanes x = b.m[0][k], y = b.m[1][k], z = b.m[2][k];
        p.m[0][k] = a.xx * x + a.xy * y + a.xz * z;
        p.m[1][k] = a.xy * x + a.yy * y + a.yz * z;
        p.m[2][k] = a.xz * x + a.yz * y + a.zz * z;
    }
    return p;
}
inline SymmetricLanes symmetric(const Lanes33& a) {
    const Lanes half = lanes_of(Real(0.5));
    return {
        a.m[0][0], a.m[1][1], a.m[2][2], half * (a.m[0][1] + a.m[1][0]), half * (a.m[0][2] + a.m[2][0]), half * (a.m[1][2] + a.m[2][1])};
}
inline Lanes33 whole(const SymmetricLanes& s) { return {{{s.xx, s.xy, s.xz}, {s.xy, s.yy, s.yz}, {s.xz, s.yz, s.zz}}}; }
inline Mat3 lane_of(const Lanes33& a, Index lane) {
    Mat3 m;
    for (int k = 0; k < 3; ++k)
        for (int l = 0; l < 3; ++l) m(k, l) = a.m[k][l][lane];
    return m;
}
inline Mat3 lane_of(const SymmetricLanes& a, Index lane) { return lane_of(whole(a), lane); }
inline void set_lane(Lanes33& a, Index lane, const Mat3& m) {
    for (int k = 0; k < 3; ++k)
        for (int l = 0; l < 3; ++l) a.m[k][l][lane] = m(k, l);
}

}  // namespace whorl
