#pragma once
/// models.notes = "as_printed": keys with the values of the source notes (docs/physics.md 14).
#include "engine/core/errors.h"
#include "engine/scene/plan.h"

namespace whorl {

/// The scene with the values that the notes print; the same scene if models.notes is "amended".
Scene as_printed(const Scene& scene);

/// Reports keys that contradict the notes, and models that the notes do not contain. @param scene the scene as read
void check_printed(const Scene& scene, const Plan& plan, std::vector<Problem>& problems);

}  // namespace whorl
