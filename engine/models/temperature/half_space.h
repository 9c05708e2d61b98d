#pragma once
/// Sums over a half-space of solid or air next to a particle, and the areas that follow from them.
#include <algorithm>
#include <vector>

#include "engine/math/kernel.h"

namespace whorl {

/// Integrals over the half-space at the distance s from a particle, tabulated over s from 0 to the support R:
///   moment(s) = int |W'| r dV      (with no distance: the whole space, = D)
///   pull(s)   = int |W'| n.r/r dV  (n: the normal; int_0^R pull ds = 1/2)
/// A particle of volume V at the distance s from a flat wall has V 2 pull(s) of the wall's area: these areas add up to the wall's.
class HalfSpace {
public:
    HalfSpace() = default;
    HalfSpace(KernelForm kernel, Real support, Real spacing);
    KernelForm kernel() const { return kernel_; }
    Real support() const { return support_; }
    Real moment(Real s) const { return at(moment_, s); }
    Real pull(Real s) const { return at(pull_, s); }
    /// Area of a wall over V, 1/m: 2 pull(s), with a factor by which the areas of a lattice that begins half a spacing from the wall are
    /// exact.
    Real wall_area(Real s) const { return scale_ * at(pull_, s); }
    /// Area that a particle shows to the air [m^2]. With the part p of moment() that it lacks, divided by that part at the flat face of a
    /// lattice, the area is d^(D-1) p, and 0 below p = 0.4. On lattices and on particles up to a fifth of a spacing off them, the total is
    /// within 7 % for boxes of 8 spacings and more, balls with a radius of 4 and sheets of 1, 3 and more layers; a sheet of two layers with
    /// a support of 3 spacings has up to a fifth too much.
    /// @param moment sum over fluid and solids @param by_solids part of it by solids next to the surface, which cover as much of the air
    Real shown_area(Real moment, Real by_solids = 0) const {
        const Real open = std::max(Real(0.3), 1 - by_solids / full_), p = (full_ - moment) / (lacking_ * open),
                   t = std::clamp(Real(2.5) * p - 1, Real(0), Real(1));
        return face_ * p * t * t * (3 - 2 * t);
    }

private:
    KernelForm kernel_;
    Real support_ = 0;
    Real at(const std::vector<Real>& table, Real s) const {
        const Real place = std::max(Real(0), s) * over_step_;
        const auto k = static_cast<std::size_t>(place);
        if (k + 1 >= table.size()) return 0;
        const Real part = place - static_cast<Real>(k);
        return (1 - part) * table[k] + part * table[k + 1];
    }
    std::vector<Real> moment_, pull_;
    Real over_step_ = 0, scale_ = 0;
    Real full_ = 0, lacking_ = 1;  ///< moment in a lattice, and what it lacks at the flat face of one
    Real face_ = 0;                ///< d^(D-1)
};

}  // namespace whorl
