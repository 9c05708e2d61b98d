#pragma once
/// Ink: passive colours that particles carry, to show where fluid comes from and how it mixes.
#include <vector>

#include "engine/math/expression_field.h"
#include "engine/models/pressure/projection/projection_system.h"
#include "engine/particles/field.h"
#include "engine/particles/interaction_context.h"

namespace whorl {

namespace field {
struct ink {
    using type = Vec3;
    static constexpr std::string_view name = "ink", unit = "", meaning = "concentrations of the three inks, 0 to 1";
};
/// Permanent random number of a particle, by which images distinguish particles.
struct grain {
    using type = Real;
    static constexpr std::string_view name = "grain", unit = "", meaning = "permanent random number of the particle, 0 to 1";
};
struct ink_change {
    using type = Vec3;
    static constexpr std::string_view name = "ink_change", unit = "", meaning = "change of the inks in a step";
};
}  // namespace field

/// c_i += dt D sum_j V |W'|/r (n_i + n_j) (c_j - c_i),   n_i = (dimensions)/sum_j V |W'| r
///
/// Brookshaw's Laplacian, with the moments n_i computed from the particles' positions. The exchange of a pair is antisymmetric, so the
/// total ink is conserved. No ink passes walls or surfaces. A step longer than the stability limit is split.
struct InkDiffusion {
    double diffusion = 0;  ///< m^2/s
    void operator()(const InteractionContext& context, Write<field::ink_change> change, Update<field::ink> c) const;
};

struct InkMarkers;

/// Sets the ink of fluid inside a box.
struct InkSource {
    Vec3 min, max;  ///< m
    ExpressionField ink;
};
struct InkSources {
    std::vector<InkSource> sources;
    void operator()(const StepContext& step, Read<field::position> x, Update<field::ink> c, InkMarkers& markers);
};

/// Runs after ProjectionMove. The shift moves particles but not the ink in space. So each particle gets the ink of its new position, as it
/// gets the velocity there. The new concentration stays within the range of those of the neighbours.
struct CarryInk {
    std::shared_ptr<ProjectionSystem> system;
    void operator()(const InteractionContext& context, Write<field::ink_change> change, Update<field::ink> c) const;
};

}  // namespace whorl
