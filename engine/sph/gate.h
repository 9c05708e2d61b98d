#pragma once
/// The gate at solids: a solid does not act on a fluid particle until enough of it is within the kernel.
#include <algorithm>

#include "engine/particles/pairs.h"

namespace whorl {

/// A solid acts on fluid particle i with the weight t^2 (3 - 2 t), t = S_i/threshold - 1/2 between 0 and 1, where S_i = sum_s V_s W_is: not
/// at all below half of the threshold, wholly from one and a half. Fluid on a lattice that touches a flat wall has S = 0.15 in its lowest
/// layer with R = 2 d, and 0.01 half a spacing further away.
struct SolidGate {
    Real threshold = 0;  ///< 0: solids always act

    /// S times its weight, and the derivative of that by S.
    struct Gated {
        Real sum, slope;
    };
    Gated gated(Real S) const {
        if (!(threshold > 0)) return {S, 1};
        const Real t = std::clamp(S / threshold - Real(0.5), Real(0), Real(1)), weight = t * t * (3 - 2 * t);
        return {S * weight, weight + S * 6 * t * (1 - t) / threshold};
    }

    /// @param volume V_s [m^3] @param factor on the volumes, see models/boundary/wall.h
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
