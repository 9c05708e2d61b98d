#include "engine/particles/drain.h"

#include "engine/core/parallel.h"

namespace whorl {

Index drain(ParticleStore& fluid, const std::vector<Drain>& drains, Real dt) {
    const auto x = fluid.column<field::position>();
    const auto role = fluid.column<field::role>();
    const auto time = fluid.column<field::time_in_drain>();
    const Index n = fluid.size();
    std::vector<char> gone(n, 0);
    parallel_for(n, [&](Index i) {
        bool inside = false;
        if (role[i] >= 0)
            for (const Drain& d : drains) {
                if (d.shape->distance(x[i]) > 0) continue;
                inside = true;
                if (time[i] + dt >= d.after) gone[i] = 1;
            }
        time[i] = inside ? time[i] + dt : 0;
    });
    std::vector<Index> kept;
    for (Index i = 0; i < n; ++i)
        if (gone[i] == 0) kept.push_back(i);
    if (static_cast<Index>(kept.size()) < n) fluid.gather(kept);
    return n - static_cast<Index>(kept.size());
}

}  // namespace whorl
