#pragma once
/// Checks of a scene against its plan. Each reports its problems with their keys.
#include <utility>

#include "engine/core/errors.h"
#include "engine/scene/plan.h"
#include "engine/scene/scene.h"
#include "engine/scene/scene_scales.h"

namespace whorl {

/// Adds a problem. Arguments: key ("solid[0].slip"), fault, fix, allowed values; the last two may be omitted.
class KeyProblems {
public:
    KeyProblems(const Scene& scene, std::vector<Problem>& problems) : scene_(scene), problems_(problems) {}
    void operator()(const std::string& key, std::string what, std::string hint = "", std::string allowed = "") const {
        problems_.push_back({scene_.place(key), std::move(what), std::move(hint), std::move(allowed)});
    }
    bool none() const { return problems_.empty(); }

private:
    const Scene& scene_;
    std::vector<Problem>& problems_;
};

void check_placement(const Scene& scene, const Plan& plan, const SceneScales& numbers, const SceneShapes& shapes,
                     std::vector<Problem>& problems);

/// Part of a block, 0 to 1, that is inside solids or nearer to them than `margin` [m]. Particles are placed at least least_clearance
/// spacings away.
double part_inside_solids(const SceneShapes& shapes, std::size_t block, double margin);
/// Part of a block, 0 to 1, that is deeper than `depth` [m] inside another block and in no solid.
double part_inside_block(const SceneShapes& shapes, std::size_t block, std::size_t other, double depth);
/// Part of the domain outside solids in which no block places fluid.
double part_left_empty(const Scene& scene, const SceneShapes& shapes);

inline constexpr double next_to_nothing = 0.02;  ///< largest part of the domain that may be empty in a full room

/// Part of its rotation that a free body loses within a turn, because at a free surface the Laplacian of each velocity component makes
/// du/dn zero, not the stress. A cylinder of radius a loses it at the rate nu (1.84/a)^2 (1.84 is the first zero of J_1').
double rotation_lost(const Plan& plan, const Scene& scene, const SceneScales& n, const SceneShapes& shapes);
inline constexpr double most_rotation_lost = 0.01;
std::string rotation_text(const Plan& plan, const Scene& scene, const SceneScales& n, const SceneShapes& shapes);
/// Adds the warnings that do not refuse the scene.
void add_warnings(Plan& plan, const Scene& scene, const SceneScales& n, const SceneShapes& shapes);

/// Whether drops miss the contact angle of this solid, cos = 2 wetting - 1, by more than 12 degrees (measured, docs/physics.md 10).
inline bool misses_angle(const PressureTraits& pressure, const SolidKeys& solid) {
    return !pressure.form && (!pressure.solves_viscosity || solid.slip != Slip::no || solid.wetting > 0.5);
}
/// Whether drops miss the contact angle of any solid of the scene.
bool misses_angle(const PressureTraits& pressure, const Scene& scene);
/// Whether the floor is dry in part, and fluid covers the rest or will fall onto it. The floor: solids below open space, or without gravity
/// at any side of it. Sampled on a lattice.
bool has_dry_floor(const Scene& scene, const SceneShapes& shapes);

void check_models(const Scene& scene, const Plan& plan, const SceneScales& numbers, const SceneShapes& shapes,
                  std::vector<Problem>& problems);

/// Reports keys of models that "auto" did not choose, and keys that a chosen form does not use. (Contradictions within the scene are found
/// when it is read.)
void check_unused_keys(const Scene& scene, const Plan& plan, std::vector<Problem>& problems);

struct ScaleWarning {
    std::string key, text;  ///< the text also names the key
};
/// Warnings for openings, domains, speeds, densities, gravity and shapes of implausible size, as a wrong unit causes.
std::vector<ScaleWarning> warnings_of_scale(const Scene& scene, const SceneShapes& shapes);

/// Warnings for solids that pass through the wall of a container (container = true), which is closed all round.
std::vector<std::string> warnings_of_lids(const Scene& scene, const SceneShapes& shapes);

}  // namespace whorl
