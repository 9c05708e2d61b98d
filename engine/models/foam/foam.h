#pragma once
/// Spray and foam: air in the fluid where it breaks up, for drawing. Acts on nothing.
#include "engine/particles/field.h"
#include "engine/particles/interaction_context.h"

namespace whorl {

namespace field {
struct foam {
    using type = Real;
    static constexpr std::string_view name = "foam", unit = "", meaning = "air in the particle's fluid: 0 clear, 1 white";
};
struct old_foam {
    using type = Real;
    static constexpr std::string_view name = "old_foam", unit = "", meaning = "foam at the start of the step";
};
struct airborne {
    using type = Real;
    static constexpr std::string_view name = "airborne", unit = "s", meaning = "time for which the particle has been spray";
};
}  // namespace field

/// df/dt = (1 - f) K (T + C)/grow - f/decay + (sum_j w f_j/sum_j w - f)/mixing,   after Ihmsen et al., "Unified spray, foam and air bubbles
/// for particle-based fluids" (2012)
///
/// T is the air trapped between particles that approach each other, sum_j w (|u_ij| - u_ij.r_ij/r) over the lattice's sum of w, near a
/// surface; C that of wave crests: a convex surface that moves outwards; K the kinetic energy. Each rises linearly from 0 to 1 between its
/// two limits; w = 1 - r/R. With the value of the particle itself instead of diffuse particles of their own, foam is stored, resumed and
/// redrawn as every other column.
///
/// A fast particle with almost no neighbours is spray, and white within `burst`. One that falls back stops being spray within `landing`.
struct Foam {
    static constexpr Real grow = Real(0.04), decay = Real(0.8), mixing = Real(0.2), burst = Real(0.03), landing = Real(0.06);  ///< s
    static constexpr Real alone = Real(0.32);       ///< share of the lattice's sum of w below which a particle is spray
    static constexpr Real spray_speed = Real(0.3);  ///< m/s
    void operator()(const InteractionContext& context, Read<field::velocity> u, Write<field::old_foam> old_foam, Update<field::foam> foam,
                    Update<field::airborne> airborne) const;
};

}  // namespace whorl
