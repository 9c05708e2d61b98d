#include "engine/sim/model_changes.h"

#include "engine/scene/names.h"
#include "engine/scene/scene_difference.h"

namespace whorl {
namespace {

/// What cannot change while a run goes on, as a scene file would have it.
NamedTexts models_of(const Plan& plan) {
    const auto number = [](double value) { return Expression(value).text(); };
    return {{"models.pressure", name_of(plan.pressure)},     {"models.viscosity", name_of(plan.viscosity)},
            {"models.micropolar", name_of(plan.micropolar)}, {"models.boundary", name_of(plan.boundary)},
            {"models.shifting", name_of(plan.shifting)},     {"fluid.kernel", name_of(plan.kernel.kind)},
            {"fluid.spacing", number(plan.spacing)},         {"fluid.support", number(plan.support)}};
}

}  // namespace

std::vector<std::string> changes_of_models(const Plan& running, const Plan& wanted) {
    return texts_of(differences(models_of(running), models_of(wanted)));
}

}  // namespace whorl
