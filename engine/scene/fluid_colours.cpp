#include <algorithm>

#include "engine/scene/scene.h"

namespace whorl {

std::size_t Scene::named_inks() const {
    std::size_t most = 0;
    const auto count = [&](const auto& list) {
        for (const auto& one : list) most = std::max(most, one.ink.of.size());
    };
    count(blocks), count(emitters), count(streams), count(vortices);
    return most;
}

std::vector<Colour> Scene::fluid_colours() const {
    std::vector<Colour> all;
    const auto add = [&](const Colour& colour) {
        if (colour.minCoeff() >= 0 && std::find(all.begin(), all.end(), colour) == all.end()) all.push_back(colour);
    };
    for (const BlockKeys& block : blocks) add(block.colour);
    for (const EmitterKeys& emitter : emitters) add(emitter.fluid_colour);
    return all;
}

Inks Scene::inks_of(const Inks& own, const Colour& colour) const {
    if (colour.minCoeff() < 0) return own;
    const std::vector<Colour> all = fluid_colours();
    Inks inks;
    inks.of.assign(named_inks() + static_cast<std::size_t>(std::find(all.begin(), all.end(), colour) - all.begin()), Expression(0.0));
    inks.of.emplace_back(1.0);
    return inks;
}

}  // namespace whorl
