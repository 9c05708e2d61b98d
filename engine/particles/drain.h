#pragma once
/// Drains: regions in which fluid is removed, immediately or after a delay.
#include <memory>
#include <vector>

#include "engine/geometry/shape.h"
#include "engine/particles/store.h"

namespace whorl {

namespace field {
struct time_in_drain {
    using type = Real;
    static constexpr std::string_view name = "time_in_drain", unit = "s",
                                      meaning = "how long the particle has been inside a drain, without leaving it";
};
}  // namespace field

struct Drain {
    std::shared_ptr<const Shape> shape;
    Real after = 0;  ///< time after which fluid inside the drain is removed [s]
};

/// Removes particles that have stayed in a drain for its delay, after a step of length dt [s]; keeps the order of the others. The store
/// must have field::time_in_drain.
/// @return the number of removed particles
Index drain(ParticleStore& fluid, const std::vector<Drain>& drains, Real dt);

}  // namespace whorl
