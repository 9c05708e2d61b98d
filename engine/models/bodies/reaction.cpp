#include "engine/models/bodies/reaction.h"

namespace whorl {
namespace {

template <class Wanted>
std::vector<Index> particles_near(const Surroundings& around, const Wanted& wanted) {
    std::vector<Index> near;
    for (Index i = 0; i < around.solid_pairs.size(); ++i) {
        bool touches = false;
        for (std::size_t k = around.solid_pairs.first[i]; k < around.solid_pairs.first[i + 1] && !touches; ++k)
            touches = wanted(static_cast<std::size_t>(around.layer.solid[around.solid_pairs.other[k]]));
        if (touches) near.push_back(i);
    }
    return near;
}

}  // namespace

std::vector<Index> particles_at(const Surroundings& around, std::size_t k) {
    return particles_near(around, [k](std::size_t solid) { return solid == k; });
}

std::vector<Index> particles_at_bodies(const Surroundings& around) {
    return particles_near(around, [&](std::size_t solid) { return around.solids.all[solid].body.has_value(); });
}

}  // namespace whorl
