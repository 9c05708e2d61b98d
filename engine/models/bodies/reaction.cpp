#include "engine/models/bodies/reaction.h"

namespace whorl {

std::vector<Index> particles_at_bodies(const Surroundings& around) {
    std::vector<Index> near;
    for (Index i = 0; i < around.solid_pairs.size(); ++i) {
        bool touches = false;
        for (std::size_t k = around.solid_pairs.first[i]; k < around.solid_pairs.first[i + 1] && !touches; ++k)
            touches = around.solids.all[around.layer.solid[around.solid_pairs.other[k]]].body.has_value();
        if (touches) near.push_back(i);
    }
    return near;
}

}  // namespace whorl
