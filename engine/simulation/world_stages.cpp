// Stages without a model: neighbours, solids; streams.
#include "engine/simulation/assemble.h"

namespace whorl {

Stage neighbours() {
    Stage stage{"neighbours", "neighbours", {{&field_info<field::position>(), Access::read}}};
    stage.run = [](World& w) {
        const auto x = std::as_const(w.fluid).column<field::position>();
        const Real support = w.step.support;
        // The last step may have found neighbours at its end. They are not reused at a frame time, because a resumed run has none.
        const bool fresh = w.step.at_frame_time;
        if (fresh || !NeighbourSearch::narrow(x, x, support, w.step.domain, w.fluid_pairs))
            w.search.find(x, support, w.step.domain, w.fluid_pairs);
        const Span<const Vec3> boundary = w.boundary_particles.position;
        if (fresh || !NeighbourSearch::narrow(x, boundary, support, w.step.domain, w.solid_pairs))
            w.search.find(x, boundary, support, w.step.domain, w.solid_pairs);
    };
    return stage;
}

Stage move_solids() {
    return {"solids", "move", {}, [](World& w) {
                w.solids.set_time(w.step.time + w.step.dt, w.step.dt);
                if (w.solids.any_moving()) w.boundary_particles.follow(w.solids);
            }};
}

std::vector<Stream> make_streams(const Scene& scene) {
    std::vector<Stream> streams;
    for (const StreamKeys& keys : scene.streams)
        streams.push_back({keys.min.cast<Real>(), keys.max.cast<Real>(), keys.velocity, keys.time});
    return streams;
}

}  // namespace whorl
