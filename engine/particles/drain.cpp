#include "engine/particles/drain.h"

#include "engine/core/parallel.h"

namespace whorl {

Index drain(ParticleStore& fluid, const std::vector<Drain>& drains, Real dt) {
    const auto x = fluid.column<field::position>();
    const auto role = fluid.column<field::role>();
    const auto time = fluid.column<field::time_in_drain>();
    const Index n = fluid.size();
    std::vector<char> gone(static_cast<std::size_t>(n), 0);
    parallel_for(n, [&](Index i) {
        const auto k = static_cast<std::size_t>(i);
        bool inside = false;
        if (role[k] >= 0)
            for (const Drain& d : drains) {
                if (d.shape->distance(x[k]) > 0) continue;
                inside = true;
                if (time[k] + dt >= d.after) gone[k] = 1;
            }
        time[k] = inside ? time[k] + dt : 0;
    });
    std::vector<Index> kept;
    for (Index i = 0; i < n; ++i)
        if (gone[static_cast<std::size_t>(i)] == 0) kept.push_back(i);
    if (static_cast<Index>(kept.size()) < n) fluid.gather(kept);
    return n - static_cast<Index>(kept.size());
}

}  // namespace whorl
