#pragma once
/// Drains: places from which fluid is taken away, at once or after it has been there for a while.
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
    Real after = 0;  ///< s: fluid that has been inside for this long is removed
};

/// Removes particles that have stayed in a drain for its delay, after a step of length dt [s]; keeps the order of the others. The store
/// must have field::time_in_drain.
/// @return how many particles went
Index drain(ParticleStore& fluid, const std::vector<Drain>& drains, Real dt);

}  // namespace whorl
