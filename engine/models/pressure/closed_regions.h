#pragma once
/// Parts of the fluid that no free surface gives a pressure: full boxes, pockets.
#include "engine/models/pressure/pressure_matrix.h"

namespace whorl {

/// A connected component of unknowns that touches no surface particle.
struct ClosedRegion {
    std::vector<Index> members;
    bool singular = false;  ///< nothing else ties it either: p is defined up to a constant
};

struct ClosedRegions {
    std::vector<ClosedRegion> all;
    /// @param matrix singular regions lose what little their pins hold @param touches_surface by particle
    void find(PressureMatrix& matrix, Span<const char> touches_surface);
    /// A singular region is solvable where its right-hand side has no mean: the walls take what is left.
    void take_means_away(Span<Real> b) const;
};

}  // namespace whorl
