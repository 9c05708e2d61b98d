#include "engine/models/bodies/body_motion.h"

#include "engine/geometry/body_contact.h"

namespace whorl {

void KickBodies::operator()(const Surroundings& around) const {
    for (Solid& solid : around.solids.all)
        if (solid.body) solid.body->velocity += static_cast<double>(around.step.dt) * around.step.gravity.cast<double>();
    around.solids.place_bodies();
    around.layer.follow(around.solids);
}

void MoveBodies::operator()(const Surroundings& around) const {
    const StepContext& step = around.step;
    ContactStep how;
    how.dt = static_cast<double>(step.dt);
    how.spacing = static_cast<double>(step.spacing);
    how.domain = step.domain;
    resolve_contacts(around.solids, around.layer, how, static_cast<double>(step.gravity.norm()));
    for (Solid& solid : around.solids.all)
        if (solid.body) solid.body->move(static_cast<double>(step.dt));
}

double lightness(const Solids& solids, const SolidParticles& layer, Real mass) {
    std::vector<double> touching(solids.all.size(), 0);
    for (const Index k : layer.solid) touching[k] += static_cast<double>(mass);
    double least = 1;
    for (std::size_t k = 0; k < solids.all.size(); ++k)
        if (solids.all[k].body && touching[k] > 0) least = std::min(least, solids.all[k].body->mass / touching[k]);
    return least;
}

}  // namespace whorl
