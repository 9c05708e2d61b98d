#pragma once
/// Moment of the pair form of the Laplacian (Brookshaw 1985): lap c_i = sum_j V |W'|/r (n_i + n_j) (c_j - c_i), n = D/moment
#include <algorithm>

#include "engine/math/kernel.h"
#include "engine/particles/pairs.h"

namespace whorl {

/// sum_j V |W'| r over the neighbours of i; about D inside the fluid.
template <class Kernel>
Real laplacian_moment(const Kernel& W, const Pairs& pairs, Index i, Real V) {
    Real moment = 0;
    pairs.groups_of(i, [&](const Pairs::Group& group) {
        for (Index l = 0; l < group.padded(); ++l) moment -= W.slope(group.distance[l]) * group.distance[l] * group.distance[l];
    });
    return V * moment;
}

/// n_i. The moment of a nearly isolated particle is about 0; the lower bound keeps it from giving more than it has.
inline Real laplacian_factor(Real moment, int dimensions) { return static_cast<Real>(dimensions) / std::max(moment, Real(0.5)); }

}  // namespace whorl
