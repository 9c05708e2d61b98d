#pragma once
/// Pressure of the fluid on a disc of a solid's surface, as a pressure gauge in a wall measures it; in two dimensions on a line.
///
/// pressure [Pa] is the mean over the disc and over the time since the row before: the normal impulse of all steps (geometry/ledger.h) over
/// time and area, so nothing is lost between rows, and discs that tile a wall add up to the pressure's part of its `solid` probe. peak [Pa]
/// is the largest mean over the disc in a single step. Both come from the impulse on the boundary particles below the disc; those at its
/// rim count in part. Fluid that pulls makes them negative. The disc moves with the solid. Empty cells: no time has passed.
#include "engine/probes/probes.h"

namespace whorl {

class GaugeProbe : public Probe {
public:
    GaugeProbe(const ProbeKeys& keys, const World& world);
    ProbeColumns columns() const override { return {{"time", "s", ""}, {"pressure", "Pa", "pressure"}, {"peak", "Pa", "pressure"}}; }
    /// Of the surface that is measured [m^2; in two dimensions m]; 0: the solid has none there.
    double area() const { return area_; }
    void after_step(const World& world, double time) override;
    ProbeRows rows(const World& world, double time) override;
    void save(std::ostream& out) const override;
    void load(std::istream& in) override;

private:
    struct Part {
        Index particle = 0;  ///< of the boundary
        double share = 0;    ///< of it that lies below the disc
    };
    struct Memory {
        double impulse = 0, time = 0, peak = 0;  ///< since the row before: N s, s, Pa
    };
    Index boundary_particles_;
    std::vector<Part> parts_;
    double area_ = 0;
    Memory memory_;
};

}  // namespace whorl
