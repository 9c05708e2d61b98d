#pragma once
/// Parts of the fluid that no free surface gives a pressure: full boxes, pockets.
#include "engine/models/pressure/pressure_matrix.h"

namespace whorl {

/// A connected component of unknowns that touches no surface particle.
struct ClosedRegion {
    std::vector<Index> members;
    bool singular = false;  ///< nothing else ties it either: p is defined up to a constant, or nearly so
};

struct ClosedRegions {
    std::vector<ClosedRegion> all;
    /// @param touches_surface by particle @param tied a region counts as singular where its pins are less than this share of its diagonals
    void find(const PressureMatrix& matrix, Span<const char> touches_surface, double tied);
    /// What little alpha a full box has comes from uneven neighbours: it would turn the right-hand side's mean into a huge uniform
    /// pressure.
    void take_pins_away(PressureMatrix& matrix) const;
    /// A singular region is solvable where its right-hand side has no mean: the walls take what is left.
    void take_means_away(Span<Real> b) const;
};

}  // namespace whorl
