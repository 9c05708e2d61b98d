#pragma once
/// Spray and foam: amount of air in breaking fluid, for drawing. It does not affect the flow.
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
/// f is the foam of a particle, w = 1 - r/R with the support radius R. T measures the air trapped between particles that approach each
/// other near a surface: sum_j w (|u_ij| - u_ij.r_ij/r), divided by the sum of w on a lattice. C measures wave crests, where a convex
/// surface moves outwards. K is the kinetic energy per mass. T, C and K are scaled to rise linearly from 0 to 1 between two limits. Unlike
/// the diffuse particles of the source, f is a column of the fluid's particles, so it is stored, resumed and drawn like other columns.
///
/// A fast particle with almost no neighbours is spray and becomes white within the time `burst`. After it has fallen back, `airborne`
/// decays within `landing`.
struct Foam {
    static constexpr Real grow = Real(0.04), decay = Real(0.8), mixing = Real(0.2), burst = Real(0.03), landing = Real(0.0125);  ///< s
    static constexpr Real alone = Real(0.32);  ///< (sum of w)/(sum of w on a lattice) below which a particle is spray
    static constexpr Real light = Real(0.4);   ///< share by which a neighbour full of air counts less in that sum: drops in spray are spray
    static constexpr Real spray_speed = Real(0.3);  ///< m/s
    void operator()(const InteractionContext& context, Read<field::velocity> u, Write<field::old_foam> old_foam, Update<field::foam> foam,
                    Update<field::airborne> airborne) const;
};

}  // namespace whorl
