#include "engine/models/bodies/body_motion.h"

namespace whorl {

void KickBodies::operator()(const InteractionContext& context) const {
    for (Solid& solid : context.solids.all)
        if (solid.body) solid.body->velocity += static_cast<double>(context.step.dt) * context.step.gravity.cast<double>();
    context.solids.place_bodies();
    context.boundary.follow(context.solids);
}

void MoveBodies::operator()(const InteractionContext& context) const {
    const StepContext& step = context.step;
    if (touch) {
        BodyContacts contacts;
        contacts.find(context.solids, context.boundary, contact_step(step));
        contacts.resolve(context.solids);
    }
    for (Solid& solid : context.solids.all)
        if (solid.body) solid.body->move(static_cast<double>(step.dt));
}

ContactStep contact_step(const StepContext& step, double clearance) {
    return {static_cast<double>(step.dt), static_cast<double>(step.spacing), static_cast<double>(step.gravity.norm()), step.domain,
            clearance};
}

double lightness(const Solids& solids, const BoundaryParticles& boundary, Real mass) {
    std::vector<double> touching(solids.all.size(), 0);
    for (const Index k : boundary.solid) touching[k] += static_cast<double>(mass);
    double least = 1;
    for (std::size_t k = 0; k < solids.all.size(); ++k)
        if (solids.all[k].body && touching[k] > 0) least = std::min(least, solids.all[k].body->mass / touching[k]);
    return least;
}

}  // namespace whorl
