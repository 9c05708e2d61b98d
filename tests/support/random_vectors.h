#pragma once
#include "engine/core/random.h"
#include "engine/core/types.h"

namespace whorl::test {

/// Three numbers in [-1, 1).
inline Vec3 random_vector(RandomNumbers& random) {
    Vec3 v;
    for (int a = 0; a < 3; ++a) v[a] = static_cast<Real>(2 * random() - 1);
    return v;
}

}  // namespace whorl::test
