#pragma once
/// Gathers values of neighbours into contiguous memory, so that loops over neighbours run in vector registers.
#if defined(__AVX512F__) && defined(__AVX512VL__)
#include <immintrin.h>
#endif

#include "engine/core/types.h"

namespace whorl {

/// Number of Reals in the widest vector register. Loops over a multiple of this number have no remainder.
inline constexpr Index most_lanes = 16;

/// out[l] = values[index[l]] for l < count, a multiple of `most_lanes`.
inline void gather(const Real* values, const Index* index, Index count, Real* out) {
#if defined(__AVX512F__) && !defined(WHORL_DOUBLE)
    // Faster than the processor's own gather.
    for (Index l = 0; l < count; l += 4) {
        __m128 four = _mm_load_ss(values + index[l]);
        four = _mm_insert_ps(four, _mm_load_ss(values + index[l + 1]), 0x10);
        four = _mm_insert_ps(four, _mm_load_ss(values + index[l + 2]), 0x20);
        _mm_storeu_ps(out + l, _mm_insert_ps(four, _mm_load_ss(values + index[l + 3]), 0x30));
    }
#else
    for (Index l = 0; l < count; ++l) out[l] = values[index[l]];
#endif
}

/// out[a][l] = vectors[index[l]][a] for l < count, a multiple of `most_lanes`.
template <std::size_t most>
void gather(const Vec3* vectors, const Index* index, Index count, Real (&out)[3][most]) {
#if defined(__AVX512F__) && defined(__AVX512VL__) && !defined(WHORL_DOUBLE)
    // Sixteen vectors at a time. Particle 4 k + a goes to quarter k of register a; each quarter is then a 4 x 4 matrix to transpose.
    const auto* v = reinterpret_cast<const float*>(vectors);
    for (Index l = 0; l < count; l += most_lanes) {
        __m512 row[4];
        for (int a = 0; a < 4; ++a) {
            const auto at = [&](int quarter) {
                return _mm_maskz_loadu_ps(0b0111, v + 3 * static_cast<std::ptrdiff_t>(index[l + 4 * quarter + a]));
            };
            row[a] =
                _mm512_insertf32x4(_mm512_insertf32x4(_mm512_insertf32x4(_mm512_castps128_ps512(at(0)), at(1), 1), at(2), 2), at(3), 3);
        }
        const __m512 xy_0 = _mm512_unpacklo_ps(row[0], row[1]), xy_1 = _mm512_unpacklo_ps(row[2], row[3]);
        const __m512 z_0 = _mm512_unpackhi_ps(row[0], row[1]), z_1 = _mm512_unpackhi_ps(row[2], row[3]);
        _mm512_storeu_ps(out[0] + l, _mm512_shuffle_ps(xy_0, xy_1, 0x44));
        _mm512_storeu_ps(out[1] + l, _mm512_shuffle_ps(xy_0, xy_1, 0xee));
        _mm512_storeu_ps(out[2] + l, _mm512_shuffle_ps(z_0, z_1, 0x44));
    }
#else
    for (Index l = 0; l < count; ++l)
        for (int a = 0; a < 3; ++a) out[a][l] = vectors[index[l]][a];
#endif
}

}  // namespace whorl
