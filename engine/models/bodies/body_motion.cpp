#include "engine/models/bodies/body_motion.h"

namespace whorl {

void KickBodies::operator()(const Surroundings& around) const {
    for (Solid& solid : around.solids.all)
        if (solid.body) solid.body->velocity += static_cast<double>(around.step.dt) * around.step.gravity.cast<double>();
    around.solids.place_bodies();
    around.layer.follow(around.solids);
}

void MoveBodies::operator()(const Surroundings& around) const {
    const StepContext& step = around.step;
    if (touch) {
        BodyContacts contacts;
        contacts.find(around.solids, around.layer, contact_step(step));
        contacts.resolve(around.solids);
    }
    for (Solid& solid : around.solids.all)
        if (solid.body) solid.body->move(static_cast<double>(step.dt));
}

ContactStep contact_step(const StepContext& step, double clearance) {
    return {static_cast<double>(step.dt), static_cast<double>(step.spacing), static_cast<double>(step.gravity.norm()), step.domain,
            clearance};
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
