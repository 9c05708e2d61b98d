#pragma once
/// Distance test of the neighbour search. Only search.cpp includes this, because its flags forbid reassociation.
#include <bit>

#ifdef __AVX512F__
#include <immintrin.h>
#endif

#include "engine/geometry/domain.h"
#include "engine/particles/search.h"

namespace whorl {

/// Parameters of the distance test.
struct DistanceTest {
    Real x[3];
    Real period[3], inverse_period[3];
    Real support2;
    Index self;
};

/// The test for filtering rows of pairs; x and self are not set.
inline DistanceTest test_for(Real support, const Domain& domain) {
    DistanceTest test{};
    test.support2 = support * support;
    const Vec3 period = domain.period();
    for (int a = 0; a < 3; ++a) {
        test.period[a] = period[a];
        test.inverse_period[a] = period[a] > 0 ? 1 / period[a] : 0;
    }
    return test;
}

/// Appends the candidates in [begin, end) that are nearer than the support to `out` and returns its new end. It may write up to
/// `most_lanes` entries past that end.
#if defined(__AVX512F__) && !defined(WHORL_DOUBLE)
template <bool periodic>
Index* append_near(const DistanceTest& test, const Real* const p[3], const Index* index, Index begin, Index end, Index* out) {
    const auto group = [&](Index k) {
        __m512 d[3];
        for (int a = 0; a < 3; ++a) {
            d[a] = _mm512_sub_ps(_mm512_set1_ps(test.x[a]), _mm512_loadu_ps(p[a] + k));
            if constexpr (periodic) {
                const __m512 images =
                    _mm512_roundscale_ps(_mm512_mul_ps(d[a], _mm512_set1_ps(test.inverse_period[a])), _MM_FROUND_TO_NEAREST_INT);
                d[a] = _mm512_fnmadd_ps(images, _mm512_set1_ps(test.period[a]), d[a]);
            }
        }
        const __m512 r2 = _mm512_fmadd_ps(d[0], d[0], _mm512_fmadd_ps(d[1], d[1], _mm512_mul_ps(d[2], d[2])));
        const __m512i j = _mm512_loadu_si512(index + k);
        const __mmask16 valid = static_cast<__mmask16>((1u << std::clamp(end - k, 0, most_lanes)) - 1);
        const __mmask16 other = _mm512_mask_cmpneq_epi32_mask(valid, j, _mm512_set1_epi32(test.self));
        const __mmask16 near = _mm512_mask_cmp_ps_mask(other, r2, _mm512_set1_ps(test.support2), _CMP_LT_OQ);
        _mm512_storeu_si512(out, _mm512_maskz_compress_epi32(near, j));
        out += std::popcount(static_cast<unsigned>(near));
    };
    for (Index k = begin; k < end;
         k += 2 * most_lanes) {  // two groups per iteration: the branch predictor is then rarely wrong about the length of a run
        group(k);
        group(k + most_lanes);
    }
    return out;
}
#else
template <bool periodic>
Index* append_near(const DistanceTest& test, const Real* const p[3], const Index* index, Index begin, Index end, Index* out) {
    for (Index k = begin; k < end; k += most_lanes) {
        Real r2[most_lanes];
        for (Index l = 0; l < most_lanes; ++l) {  // always whole groups, so that every pair is computed by the same instructions
            Real d[3];
            for (int a = 0; a < 3; ++a) {
                d[a] = test.x[a] - p[a][k + l];
                if constexpr (periodic) d[a] -= test.period[a] * std::nearbyint(d[a] * test.inverse_period[a]);
            }
            r2[l] = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
        }
        const Index count = std::min(most_lanes, end - k);
        for (Index l = 0; l < count; ++l) {
            const Index j = index[k + l];
            *out = j;
            out += (r2[l] < test.support2) & (j != test.self);
        }
    }
    return out;
}
#endif

}  // namespace whorl
