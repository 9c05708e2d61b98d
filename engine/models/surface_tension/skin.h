#pragma once
/// How much of surface a particle is, so that the fluid's skin alone pulls.
///
/// If all pairs pull, the inside is pressed with many times the 2 sigma/R that the surface asks for, and particles pressed that
/// hard do not flow: they jam. A particle that has its neighbours needs no pull. c is the potential that its neighbours give it over
/// that inside a lattice; the share s(c) is 1 up to c = bare and 0 from c = complete on, which a packed, moving inside does not fall
/// below. Pairs pull with (s_i + s_j)/2 times strength().
#include <algorithm>

#include "engine/core/types.h"

namespace whorl {

struct Skin {
    static constexpr double bare = 0.9, complete = 0.985;  ///< the outermost layer of a lattice has c = 0.69, the second 0.95
    /// The tension that drops of 6 to 11 spacings in radius have, over that of a uniform density: their outermost particles come a
    /// little closer. Chosen between the values from pressure and period (0.86 to 0.88, 0.88 to 0.95).
    static constexpr double packed = 0.9;
    /// For pulls that are spread over the neighbours, which adds to the tension: drops of 6 and 8 spacings from a lattice,
    /// jittered and of blue noise have 1.41 to 1.61 in their pressure, 1.47 in their period.
    static constexpr double packed_spread = 1.5;

    static Real share(Real c) {
        const Real t = std::clamp((Real(complete) - c) / Real(complete - bare), Real(0), Real(1));
        return t * t * (3 - 2 * t);
    }
    /// Tension of a flat face of uniform density with these shares over that of all pairs: n/2 int s(z) z pull(z) dz over sigma,
    /// pull(z) that of a half-space at the distance z.
    static double flat_tension();
    /// S = 1/(packed flat_tension()), which makes the skin's tension sigma.
    static double strength(bool spread = false);
};

}  // namespace whorl
