#include "render/surface/ghosts.h"

namespace whorl {

Ghosted with_ghosts(const Frame& frame, float margin) {
    Ghosted all;
    if (!frame.periodic[0] && !frame.periodic[1] && !frame.periodic[2]) return all;
    all.position = frame.position;
    all.original.resize(frame.position.size());
    for (std::size_t i = 0; i < all.original.size(); ++i) all.original[i] = static_cast<Index>(i);
    for (int a = 0; a < 3; ++a) {
        if (!frame.periodic[a]) continue;
        const float period = frame.domain_max[a] - frame.domain_min[a];
        const std::size_t count = all.position.size();  // with the copies along the axes before: corners come by themselves
        // A domain narrower than the margin is repeated as often as it takes.
        for (int times = 1; static_cast<float>(times - 1) * period < margin; ++times)
            for (const float shift : {-static_cast<float>(times) * period, static_cast<float>(times) * period})
                for (std::size_t i = 0; i < count; ++i) {
                    const float x = all.position[i][a] + shift;
                    if (x < frame.domain_min[a] - margin || x > frame.domain_max[a] + margin) continue;
                    Vec3f copy = all.position[i];
                    copy[a] = x;
                    all.position.push_back(copy);
                    all.original.push_back(all.original[i]);
                }
    }
    return all;
}

Cut cut_of(const Frame& frame) {
    Cut cut;
    for (int a = 0; a < 3; ++a)
        if (frame.periodic[a]) cut.low[a] = frame.domain_min[a], cut.high[a] = frame.domain_max[a];
    return cut;
}

}  // namespace whorl
