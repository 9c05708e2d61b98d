#pragma once
/// Checks of a scene against its plan: each reports problems with their keys.
#include <utility>

#include "engine/core/errors.h"
#include "engine/scene/plan.h"
#include "engine/scene/scene.h"
#include "engine/scene/scene_scales.h"

namespace whorl {

/// Called with a key ("solid[0].slip"), its fault, a fix and the allowed values; the last two may be left out.
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

/// The part of a block, 0 to 1, that lies inside solids, or nearer to them than `margin` [m]: no particle is placed within least_clearance
/// spacings.
double part_inside_solids(const SceneShapes& shapes, std::size_t block, double margin);
/// The part of a block, 0 to 1, that lies deeper than `depth` [m] inside another block, and in no solid.
double part_inside_block(const SceneShapes& shapes, std::size_t block, std::size_t other, double depth);
/// Share of the domain outside the solids where no block puts fluid at the start.
double part_left_empty(const Scene& scene, const SceneShapes& shapes);

/// Whether drops do not meet this solid at the angle of its wetting; measured (docs/physics.md 10).
inline bool loses_angle(const PressureTraits& pressure, const SolidKeys& solid) {
    return !pressure.form && (!pressure.solves_viscosity || solid.slip != Slip::no);
}

void check_models(const Scene& scene, const Plan& plan, const SceneScales& numbers, const SceneShapes& shapes,
                  std::vector<Problem>& problems);

/// Reports keys of other models than those that "auto" chose, and keys that a chosen form does not use. (Contradictions within the scene
/// are found when it is read.)
void check_unused_keys(const Scene& scene, const Plan& plan, std::vector<Problem>& problems);

struct ScaleWarning {
    std::string key, text;  ///< the text names the key, too
};
/// A warning for each opening, domain, speed, density, gravity or shape that is out of proportion, as a wrong unit makes it.
std::vector<ScaleWarning> warnings_of_scale(const Scene& scene, const SceneShapes& shapes);

/// Warnings about solids that move through the wall of a container (container = true), which is closed all round.
std::vector<std::string> warnings_of_lids(const Scene& scene, const SceneShapes& shapes);

}  // namespace whorl
