#pragma once
/// Interface between the pressure solves and their preconditioners.
#include <functional>
#include <vector>

#include "engine/core/types.h"

namespace whorl {

/// z is near A^-1 r, symmetric and positive definite on the unknowns; z = 0 elsewhere.
struct PressurePreconditioner {
    std::function<void(Span<const Real> r, Span<Real> z)> apply;
    int levels = 1;
    std::size_t bytes = 0;  ///< its memory

    void operator()(Span<const Real> r, Span<Real> z) const { apply(r, z); }
};

}  // namespace whorl
