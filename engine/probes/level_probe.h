#pragma once
/// Height of the surface along a line, counted from the line's first point.
///
/// The surface lies where the fluid's share c of the volume falls through half of what solids leave free:
///     c(x) = sum V W(|x - x_j|),   c = (1 - w)/2,
/// W the Wendland C2 function three spacings wide, V a particle's volume and w the solids' share of the same function. So it is exact to
/// half a spacing, beside walls too. The line is followed from its first point as long as it is in fluid, so drops above the surface do not
/// count; solids on the way are passed. Height is 0 if no fluid is within a spacing of where the line begins (or leaves the solid that it
/// begins in), and the line's length if all of it is in fluid.
#include "engine/probes/probes.h"

namespace whorl {

class LevelProbe : public Probe {
public:
    explicit LevelProbe(const ProbeKeys& keys) : from_(keys.from), to_(keys.to) {}
    ProbeColumns columns() const override { return {{"time", "s", ""}, {"height", "m", "height of the surface"}}; }
    ProbeRows rows(const World& world, double time) override;

private:
    double height(const World& world) const;
    Vec3d from_, to_;
};

}  // namespace whorl
