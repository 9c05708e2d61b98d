#pragma once
/// Gate at solids: a solid acts on a fluid particle only if enough of it is within the kernel.
#include <algorithm>

#include "engine/particles/pairs.h"

namespace whorl {

/// A solid acts on fluid particle i with the weight t^2 (3 - 2 t), where t = S_i/threshold - 1/2 is limited to [0, 1] and S_i = sum_s V_s
/// W_is. So the weight is 0 below half of the threshold, and 1 above one and a half times it. For fluid on a lattice at a flat wall with R
/// = 2 d, S = 0.15 in the lowest layer, and 0.01 half a spacing farther away.
struct SolidGate {
    Real threshold = 0;  ///< 0: solids always act

    /// S times its weight, and the derivative of this product with respect to S.
    struct Gated {
        Real sum, slope;
    };
    Gated gated(Real S) const {
        if (!(threshold > 0)) return {S, 1};
        const Real t = std::clamp(S / threshold - Real(0.5), Real(0), Real(1)), weight = t * t * (3 - 2 * t);
        return {S * weight, weight + S * 6 * t * (1 - t) / threshold};
    }

    /// The weight for fluid particle i. @param volume V_s [m^3] @param factor on the volumes, see models/boundary/wall.h
    template <class Kernel>
    Real weight(const Kernel& W, Index i, const Pairs& solid_pairs, Span<const Real> volume, Real factor) const {
        if (!(threshold > 0)) return 1;
        Real sum = 0;
        solid_pairs.of(i, [&](Index s, const Vec3&, Real distance) { sum += volume[s] * W.value(distance); });
        const Real t = std::clamp(factor * sum / threshold - Real(0.5), Real(0), Real(1));
        return t * t * (3 - 2 * t);
    }
};

}  // namespace whorl
